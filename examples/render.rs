//! Renders a scene file to an OpenEXR file: `cargo run --release --example render -- SCENE.glb PICTURE.exr`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;
use sundog::render::Silent;
use sundog::{Session, Settings};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, picture] = &arguments[..] else {
        return Err("two arguments are needed: SCENE.glb PICTURE.exr".into());
    };
    let mut loaded = sundog::load(Path::new(scene))?;
    if loaded.scene.cameras.is_empty() {
        // A scene without a camera is seen by one that frames all of it.
        loaded.scene.cameras.extend(loaded.scene.framed());
    }
    let settings = Settings {
        width: 640,
        height: 360,
        samples: 64,
        ..Settings::default()
    };
    let rendering = Session::new(&loaded.scene, settings).render(&Silent)?;
    let statistics = &rendering.statistics;
    println!(
        "{} rays in {:.1} s",
        statistics.rays,
        statistics.trace.as_secs_f64()
    );
    if let Some(error) = &statistics.error {
        println!("estimated error: {error:?}");
    }
    sundog::output::exr::write(
        Path::new(picture),
        &rendering.picture,
        &sundog::output::exr::ExrOptions::default(),
        &sundog::output::Metadata::default(),
    )?;
    Ok(())
}
