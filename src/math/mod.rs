//! Floating-point bounds, frames, warps.
