//! Passes of data by the ray through each pixel's middle.

use super::{linking, run, small};
use sundog::film::{Pass, Passes};
use sundog::render::{RenderSettings, Rendering};

fn rendered(center_passes: bool, samples: u32) -> Rendering {
    let passes = [
        Pass::Depth,
        Pass::Normal,
        Pass::Uv,
        Pass::Mist,
        Pass::CryptoObject00,
        Pass::DiffuseDirect,
    ];
    let settings = RenderSettings {
        passes: passes.into_iter().fold(Passes::COMBINED, Passes::with),
        center_passes,
        ..small(samples, 2)
    };
    run(&linking::scene(), &settings)
}

fn layer<'a>(rendering: &'a Rendering, name: &str) -> &'a [f32] {
    let mut layers = rendering.picture.layers.iter();
    &layers.find(|layer| layer.name == name).unwrap().data
}

#[test]
fn no_value_is_a_mean_of_two_surfaces() {
    let found = rendered(true, 20);
    let depths = layer(&found, "Depth");
    let normals = layer(&found, "Normal").chunks(3);
    let mattes = layer(&found, "CryptoObject00").chunks(4);
    let covered = layer(&found, "UV").chunks(3);
    let (mut met, mut missed) = (0, 0);
    for (((depth, normal), matte), uv) in depths.iter().zip(normals).zip(mattes).zip(covered) {
        let there = *depth < 1e10;
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
        let expected = if there { 1.0 } else { 0.0 };
        // The sums of normals are in steps of 2⁻³².
        assert!((length - expected).abs() < 1e-6, "{normal:?}");
        assert_eq!((matte[1], matte[3]), (expected, 0.0));
        assert_eq!(uv[2], expected);
        (met, missed) = (met + i32::from(there), missed + i32::from(!there));
    }
    assert!(met > 0 && missed > 0, "{met} {missed}");
    // With filtering some are.
    let filtered = rendered(false, 20);
    let mixed = layer(&filtered, "CryptoObject00").chunks(4);
    assert!(mixed.into_iter().any(|m| m[1] > 0.0 && m[1] < 1.0));
}

#[test]
fn light_stays_and_more_samples_change_no_data() {
    let (plain, center) = (rendered(false, 20), rendered(true, 20));
    for name in ["Combined", "DiffDir", "Depth"] {
        assert_eq!(layer(&plain, name), layer(&center, name), "{name}");
    }
    let few = rendered(true, 3);
    for name in ["Normal", "UV", "Mist", "CryptoObject00"] {
        let pairs = layer(&few, name).iter().zip(layer(&center, name));
        // Rounded once.
        assert!(
            pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-6),
            "{name}"
        );
    }
}
