//! One test binary; each module is a subject.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr
)]

mod architecture;
mod blender_layers;
mod cli;
mod color;
mod denoise;
mod docs;
mod formats;
mod fuzz;
mod hard_cases;
mod measures;
mod package;
mod pictures;
mod preparation;
mod report;
mod session;
mod transport;
