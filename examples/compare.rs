//! Says how far a picture is from a reference: `cargo run --release --example compare -- PICTURE.exr REFERENCE.exr`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;
use sundog::measure;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [picture, reference] = &arguments[..] else {
        return Err("two arguments are needed: PICTURE.exr REFERENCE.exr".into());
    };
    let load = |path: &str| measure::load(Path::new(path), None);
    let difference = measure::difference(&load(picture)?, &load(reference)?)?;
    println!("relMSE {:.3e}", difference.rel_mse);
    println!("FLIP   {:.4}", difference.flip);
    if let Some(ratio) = difference.luminance_ratio {
        println!("mean luminance {ratio:.4} times the reference's");
    }
    Ok(())
}
