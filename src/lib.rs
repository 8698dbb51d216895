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
pub mod denoise;
pub mod effects;
pub mod ffi;
pub mod film;
pub mod import;
pub mod integrator;
pub mod light;
pub mod math;
pub mod measure;
pub mod medium;
pub mod nodes;
pub mod output;
pub mod render;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod selftest;
pub mod shading;
pub mod world;

pub use film::Picture;
pub use import::Imported;
pub use render::{Edit, RenderSettings as Settings, Session};
pub use scene::Scene;

/// Reads a scene file (`.glb` or `.gltf`) with default choices, ready to be rendered.
///
/// ```no_run
/// let loaded = sundog::load("scene.glb".as_ref())?;
/// let settings = sundog::Settings { samples: 64, ..sundog::Settings::default() };
/// let rendering = sundog::Session::new(&loaded.scene, settings).render(&sundog::render::Silent)?;
/// println!("{} layers", rendering.picture.layers.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The file, or one that it names, cannot be read or is malformed; the sentence names it and the way out.
pub fn load(path: &std::path::Path) -> Result<Imported, import::ImportError> {
    let mut imported = import::load(path, &import::ImportOptions::default())?;
    world::displace(&mut imported.scene, &mut imported.diagnostics);
    Ok(imported)
}
