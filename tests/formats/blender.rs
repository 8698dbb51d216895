//! What Blender's own exporter writes means in Sundog what it means in Blender.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::Command;

use approx::assert_relative_eq;
use glam::DVec3;
use sundog::import::{self, ImportOptions, LightUnits};
use sundog::scene::{LightKind, Projection};

use super::kit::{codes, standard};

/// Runs one of this folder's scripts with Blender 4.5 as a Python module: `$SUNDOG_BPY_PYTHON`
/// if that is set, else where the set-up puts it.
pub fn run_script(script: &str, folder: &Path) {
    let python = std::env::var_os("SUNDOG_BPY_PYTHON")
        .map(PathBuf::from)
        .unwrap_or_else(|| {
            let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
            let home =
                || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache");
            cache
                .unwrap_or_else(home)
                .join("sundog/bpy-4.5.15/bin/python")
        });
    let script = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/formats")
        .join(script);
    let output = Command::new(&python).arg(&script).arg(folder).output();
    let output = output.unwrap_or_else(|e| {
        panic!(
            "cannot run {} ({e}): run scripts/setup-bpy.sh 4.5.15",
            python.display()
        )
    });
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn lamps_and_cameras_of_a_real_export() {
    let folder = tempfile::tempdir().unwrap();
    run_script("export_kinds.py", folder.path());
    for (mode, light_units) in [
        ("SPEC", LightUnits::Standard),
        ("COMPAT", LightUnits::Unitless),
        ("RAW", LightUnits::Raw),
    ] {
        let options = ImportOptions {
            light_units,
            ..ImportOptions::default()
        };
        let imported = import::load(&folder.path().join(format!("{mode}.glb")), &options).unwrap();
        let scene = &imported.scene;
        assert_eq!(codes(&imported), ["no-material"], "{mode}");
        let light = |name: &str| scene.lights.iter().find(|l| l.name == name).unwrap();
        let LightKind::Point {
            intensity, radius, ..
        } = light("point").kind
        else {
            panic!()
        };
        assert_relative_eq!(
            f64::from(intensity),
            100.0 / (4.0 * PI),
            max_relative = 1e-6
        );
        assert_eq!(radius, 0.0);
        assert_eq!(light("point").color, [1.0, 0.5, 0.25]);
        let LightKind::Spot {
            intensity,
            half_angle,
            blend,
            ..
        } = light("spot").kind
        else {
            panic!()
        };
        // One stop of exposure doubles the 50 W.
        assert_relative_eq!(
            f64::from(intensity),
            100.0 / (4.0 * PI),
            max_relative = 1e-6
        );
        assert_relative_eq!(half_angle, 0.6, max_relative = 1e-6);
        assert_relative_eq!(blend, 0.15, max_relative = 1e-5);
        let LightKind::Sun { irradiance, .. } = light("sun").kind else {
            panic!()
        };
        assert_relative_eq!(irradiance, 3.0, max_relative = 1e-6);
        // Blender's lamps look down their -Z, which is down in Blender's world and in glTF's.
        let down = light("sun")
            .world_from_light
            .transform_vector3(DVec3::NEG_Z);
        assert!(down.abs_diff_eq(DVec3::NEG_Y, 1e-6), "{down}");

        let camera = &scene.cameras[0];
        assert_eq!(camera.name, "camera");
        assert!(
            camera
                .world_from_camera
                .translation
                .abs_diff_eq(DVec3::new(1.0, 3.0, -2.0), 1e-6)
        );
        let Projection::Perspective {
            vertical_fov,
            aspect,
        } = camera.projection
        else {
            panic!()
        };
        // The sensor's width spans the picture's: tan(half) = (36 / 2 / 35) · (200 / 320).
        assert_relative_eq!(
            (vertical_fov / 2.0).tan(),
            36.0 / 70.0 * 0.625,
            max_relative = 1e-6
        );
        assert_relative_eq!(aspect.unwrap(), 1.6, max_relative = 1e-6);
        assert_relative_eq!(camera.clip_near, 0.25, max_relative = 1e-6);
        assert_relative_eq!(camera.clip_far, 75.0, max_relative = 1e-6);

        assert_eq!(scene.instances[0].name, "bare");
        let material = &scene.materials[scene.meshes[0].material.unwrap().0 as usize];
        let material = standard(material);
        assert_eq!((material.base_color, material.specular), ([0.8; 3], 0.0));
    }
}
