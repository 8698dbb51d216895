//! Foreign functions: Embree and OpenColorIO, each wrapped once in safe types.
//! The only room with foreign `unsafe`; the system's allocator is one of them.

pub mod embree;
pub mod memory;
pub mod ocio;
