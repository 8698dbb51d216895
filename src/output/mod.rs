//! EXR, PNG and JPEG files, written beside and then renamed.
