//! Sundog: a CPU path tracer for Blender scenes. It traces with Embree, shows with OpenColorIO,
//! and says what the accuracy of its pictures cost.
//!
//! The rooms and the way of the data are described in `ARCHITECTURE.md`; `tests/architecture.rs`
//! keeps the arrows between them true.
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::print_stdout,
        clippy::print_stderr
    )
)]

pub mod camera;
pub mod cli;
pub mod color;
pub mod cost;
pub mod effects;
pub mod ffi;
pub mod film;
pub mod hard;
pub mod import;
pub mod integrator;
pub mod light;
pub mod math;
pub mod measure;
pub mod medium;
pub mod output;
pub mod render;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod shading;
pub mod world;
