//! Foreign functions: Embree, OpenColorIO and Open Image Denoise, each wrapped once in safe types.
//! The only room with foreign `unsafe`; the system's allocator and its mapped files are of them.

pub mod embree;
pub mod memory;
pub mod ocio;
pub mod oidn;
pub mod scratch;
pub mod values;
