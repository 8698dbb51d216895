//! Renders a scene file, moves its camera, renders it again, and says what that cost:
//! `cargo run --release --example edit -- SCENE.glb`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;
use std::time::Instant;
use sundog::render::Silent;
use sundog::{Edit, Session, Settings};

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args()
        .nth(1)
        .ok_or("one argument is needed: SCENE.glb")?;
    let mut loaded = sundog::load(Path::new(&scene))?;
    if loaded.scene.cameras.is_empty() {
        loaded.scene.cameras.extend(loaded.scene.framed());
    }
    let mut camera = loaded
        .scene
        .cameras
        .first()
        .cloned()
        .ok_or("the scene is empty")?;
    let settings = Settings {
        width: 320,
        height: 180,
        samples: 4,
        ..Settings::default()
    };
    let mut session = Session::owning(loaded.scene, settings);
    for step in 0..5 {
        let begun = Instant::now();
        let made = session.prepare()?;
        let prepared = begun.elapsed();
        session.render(&Silent)?;
        println!(
            "step {step}: {prepared:.1?} to prepare ({made:?}), {:.1?} in all",
            begun.elapsed()
        );
        // A hundredth of a metre to the right.
        camera.world_from_camera.translation += 0.01 * camera.world_from_camera.matrix3.x_axis;
        session.apply(Edit::Camera {
            number: 0,
            camera: camera.clone(),
        })?;
    }
    Ok(())
}
