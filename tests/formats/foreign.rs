//! A look at files that are not part of the project.

use std::path::{Path, PathBuf};

use sundog::import::{self, ImportOptions};

fn scene_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut entries: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            scene_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
}

/// Loads every glTF below `$SUNDOG_SCENE_FOLDER` and prints what came of it.
#[test]
#[ignore = "a look at files that are not part of the project"]
fn a_folder_of_foreign_scenes() {
    let folder = std::env::var("SUNDOG_SCENE_FOLDER").expect("set SUNDOG_SCENE_FOLDER");
    let mut files = Vec::new();
    scene_files(Path::new(&folder), &mut files);
    assert!(!files.is_empty(), "no scenes in {folder}");
    for path in files {
        let start = std::time::Instant::now();
        let name = path
            .strip_prefix(&folder)
            .unwrap_or(&path)
            .display()
            .to_string();
        match import::load(&path, &ImportOptions::default()) {
            Err(error) => println!("{name}: ERROR {error}"),
            Ok(imported) => {
                let scene = &imported.scene;
                let triangles: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
                println!(
                    "{name}: {} meshes, {} instances, {triangles} triangles, {} materials, {} images, {} lights, {} cameras, {:.0} ms",
                    scene.meshes.len(),
                    scene.instances.len(),
                    scene.materials.len(),
                    scene.images.len(),
                    scene.lights.len(),
                    scene.cameras.len(),
                    start.elapsed().as_secs_f64() * 1e3,
                );
                for message in imported.diagnostics.iter() {
                    println!("    {:?} [{}] {message}", message.verdict, message.code);
                }
            }
        }
    }
}
