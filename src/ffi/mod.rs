//! Foreign functions: Embree and OpenColorIO, each wrapped once in safe types.
//! The only room with foreign `unsafe`.

pub mod embree;
pub mod ocio;
