//! Every node beside Cycles' own values (tests/nodes, made by tests/python/texture_values.py).

use std::path::Path;

use glam::{Vec3, Vec4};
use serde_json::Value;

use super::*;

/// One variant of a node: its menus, the numbers in its sockets, and what Cycles of a version makes of some points.
struct Variant(Value, CyclesVersion);

impl Variant {
    fn choice<T>(&self, name: &str, from_name: fn(&str) -> Option<T>, otherwise: T) -> T {
        match self.0["settings"].get(name) {
            None => otherwise,
            Some(value) => from_name(value.as_str().unwrap()).unwrap(),
        }
    }

    fn setting(&self, name: &str, otherwise: f32) -> f32 {
        let value = &self.0["settings"][name];
        value.as_f64().map_or(otherwise, |number| number as f32)
    }

    fn number(&self, name: &str) -> f32 {
        self.0["inputs"][name].as_f64().unwrap() as f32
    }

    fn vector(&self, name: &str) -> Vec3 {
        let value = &self.0["inputs"][name];
        Vec3::from_array(std::array::from_fn(|i| value[i].as_f64().unwrap() as f32))
    }

    /// The node's outputs by Blender's identifiers.
    fn outputs(&self, p: Vec4) -> Vec<(&'static str, Vec<f32>)> {
        let (vector, w) = (p.truncate(), p.w);
        let fac_and_color = |(fac, color): (f32, Vec3)| {
            vec![("Fac", vec![fac]), ("Color", color.to_array().to_vec())]
        };
        let grey = |fac: f32| fac_and_color((fac, Vec3::splat(fac)));
        match self.0["node"].as_str().unwrap() {
            "Noise" => {
                let settings = self.noise_settings();
                let inputs = self.noise_inputs(p);
                let (fac, color) = noise(&settings, &inputs);
                assert_eq!(fac.to_bits(), noise_fac(&settings, &inputs).to_bits());
                fac_and_color((fac, color))
            }
            "WhiteNoise" => {
                let dimensions =
                    self.choice("noise_dimensions", Dimensions::from_name, Dimensions::Three);
                let (value, color) = white_noise(dimensions, vector, w);
                assert_eq!(value, white_noise_value(dimensions, vector, w));
                vec![("Value", vec![value]), ("Color", color.to_array().to_vec())]
            }
            "Wave" => grey(self.wave(vector)),
            "Magic" => {
                let inputs = MagicInputs {
                    vector,
                    scale: self.number("Scale"),
                    distortion: self.number("Distortion"),
                };
                let depth = self.setting("turbulence_depth", 2.0) as u8;
                fac_and_color(magic(MagicSettings::of(self.1, depth), &inputs))
            }
            "Brick" => fac_and_color(self.brick(vector)),
            "Checker" => fac_and_color(checker(&CheckerInputs {
                vector,
                color1: self.vector("Color1"),
                color2: self.vector("Color2"),
                scale: self.number("Scale"),
            })),
            "Gradient" => grey(gradient(
                self.choice(
                    "gradient_type",
                    GradientType::from_name,
                    GradientType::Linear,
                ),
                vector,
            )),
            "Voronoi" => {
                let found = self.voronoi(p);
                vec![
                    ("Distance", vec![found.distance]),
                    ("Color", found.color.to_array().to_vec()),
                    ("Position", found.position.to_array().to_vec()),
                    ("W", vec![found.w]),
                    ("Radius", vec![found.radius]),
                ]
            }
            "Gabor" => {
                let gabor_type = self.choice("gabor_type", GaborType::from_name, GaborType::TwoD);
                let inputs = GaborInputs {
                    vector,
                    scale: self.number("Scale"),
                    frequency: self.number("Frequency"),
                    anisotropy: self.number("Anisotropy"),
                    orientation_2d: self.number("Orientation 2D"),
                    orientation_3d: self.vector("Orientation 3D"),
                };
                let found = gabor(gabor_type, &inputs);
                vec![
                    ("Value", vec![found.value]),
                    ("Phase", vec![found.phase]),
                    ("Intensity", vec![found.intensity]),
                ]
            }
            node => panic!("no node {node}"),
        }
    }

    fn noise_settings(&self) -> NoiseSettings {
        NoiseSettings {
            dimensions: self.choice("noise_dimensions", Dimensions::from_name, Dimensions::Three),
            noise_type: self.choice("noise_type", NoiseType::from_name, NoiseType::Fbm),
            normalize: self.0["settings"]["normalize"].as_bool().unwrap_or(true),
        }
    }

    fn noise_inputs(&self, p: Vec4) -> NoiseInputs {
        NoiseInputs {
            vector: p.truncate(),
            w: p.w,
            scale: self.number("Scale"),
            detail: self.number("Detail"),
            roughness: self.number("Roughness"),
            lacunarity: self.number("Lacunarity"),
            offset: self.number("Offset"),
            gain: self.number("Gain"),
            distortion: self.number("Distortion"),
        }
    }

    fn voronoi(&self, p: Vec4) -> VoronoiOutputs {
        let settings = VoronoiSettings {
            dimensions: self.choice(
                "voronoi_dimensions",
                Dimensions::from_name,
                Dimensions::Three,
            ),
            feature: self.choice("feature", VoronoiFeature::from_name, VoronoiFeature::F1),
            metric: self.choice(
                "distance",
                VoronoiMetric::from_name,
                VoronoiMetric::Euclidean,
            ),
            normalize: self.0["settings"]["normalize"].as_bool().unwrap_or(false),
            hash: VoronoiHash::of(self.1),
        };
        let inputs = VoronoiInputs {
            vector: p.truncate(),
            w: p.w,
            scale: self.number("Scale"),
            detail: self.number("Detail"),
            roughness: self.number("Roughness"),
            lacunarity: self.number("Lacunarity"),
            smoothness: self.number("Smoothness"),
            exponent: self.number("Exponent"),
            randomness: self.number("Randomness"),
        };
        voronoi(&settings, &inputs)
    }

    fn wave(&self, vector: Vec3) -> f32 {
        let settings = WaveSettings {
            wave_type: self.choice("wave_type", WaveType::from_name, WaveType::Bands),
            bands_direction: self.choice(
                "bands_direction",
                WaveBandsDirection::from_name,
                WaveBandsDirection::X,
            ),
            rings_direction: self.choice(
                "rings_direction",
                WaveRingsDirection::from_name,
                WaveRingsDirection::X,
            ),
            profile: self.choice("wave_profile", WaveProfile::from_name, WaveProfile::Sin),
        };
        let inputs = WaveInputs {
            vector,
            scale: self.number("Scale"),
            distortion: self.number("Distortion"),
            detail: self.number("Detail"),
            detail_scale: self.number("Detail Scale"),
            detail_roughness: self.number("Detail Roughness"),
            phase_offset: self.number("Phase Offset"),
        };
        wave(&settings, &inputs)
    }

    fn brick(&self, vector: Vec3) -> (f32, Vec3) {
        let settings = BrickSettings {
            offset: self.setting("offset", 0.5),
            offset_frequency: self.setting("offset_frequency", 2.0) as u8,
            squash: self.setting("squash", 1.0),
            squash_frequency: self.setting("squash_frequency", 2.0) as u8,
            ..Default::default()
        };
        let inputs = BrickInputs {
            vector,
            color1: self.vector("Color1"),
            color2: self.vector("Color2"),
            mortar: self.vector("Mortar"),
            scale: self.number("Scale"),
            mortar_size: self.number("Mortar Size"),
            mortar_smooth: self.number("Mortar Smooth"),
            bias: self.number("Bias"),
            brick_width: self.number("Brick Width"),
            row_height: self.number("Row Height"),
        };
        brick(&settings, &inputs)
    }
}

/// Cycles' numbers out of the bits of a variant's output.
fn floats(value: &Value) -> Vec<f32> {
    let digits = value.as_str().unwrap().as_bytes();
    let number = |digits: &[u8]| u32::from_str_radix(std::str::from_utf8(digits).unwrap(), 16);
    let bits = digits.chunks(8).map(|digits| number(digits).unwrap());
    bits.map(f32::from_bits).collect()
}

/// What two values differ by: of numbers above 1, a share.
fn difference(ours: f32, theirs: f32) -> f32 {
    if ours == theirs || (ours.is_nan() && theirs.is_nan()) {
        return 0.0;
    }
    let difference = (ours - theirs).abs() / theirs.abs().max(1.0);
    if difference.is_nan() {
        f32::INFINITY
    } else {
        difference
    }
}

/// Largest difference that a value may have. Rounding alone makes at most 6e-6, where distortion moves 1D noise.
const TOLERANCE: f32 = 1e-5;

/// A file of tests/nodes.
fn read(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/nodes/{name}.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Compares every output of every variant of a node with Cycles' values.
fn agrees(node: &str, variants_at_least: usize) {
    let file = read(node);
    let point = |value: &Value| {
        Vec4::from_array(std::array::from_fn(|i| value[i].as_f64().unwrap() as f32))
    };
    let points: Vec<Vec4> = read("points")
        .as_array()
        .unwrap()
        .iter()
        .map(point)
        .collect();
    let blender = file["blender"].as_str().unwrap();
    // As "5.2.3 LTS".
    let version = blender.split(' ').next().unwrap().parse().unwrap();
    let variants = file["variants"].as_array().unwrap();
    assert!(variants.len() >= variants_at_least, "{}", variants.len());
    for variant in variants {
        let number = |name: &str| variant[name].as_u64().unwrap() as usize;
        let taken = &points[number("first")..][..number("count")];
        let ours: Vec<_> = taken
            .iter()
            .map(|p| Variant(variant.clone(), version).outputs(*p))
            .collect();
        for (output, values) in variant["outputs"].as_object().unwrap() {
            let theirs = floats(values);
            let ours = ours.iter().flat_map(|outputs| {
                let found = outputs.iter().find(|(name, _)| name == output);
                found.unwrap().1.clone()
            });
            let ours: Vec<f32> = ours.collect();
            assert_eq!(ours.len(), theirs.len());
            let channels = ours.len() / taken.len();
            for (index, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
                assert!(
                    difference(*ours, *theirs) <= TOLERANCE,
                    "{output} at {}: {ours}, in Cycles {theirs}: {} {}",
                    taken[index / channels],
                    variant["settings"],
                    variant["inputs"],
                );
            }
        }
    }
}

#[test]
fn noise_is_that_of_cycles() {
    agrees("Noise", 44);
}

#[test]
fn white_noise_is_that_of_cycles() {
    agrees("WhiteNoise", 4);
}

#[test]
fn waves_are_those_of_cycles() {
    agrees("Wave", 26);
}

#[test]
fn magic_is_that_of_cycles() {
    agrees("Magic", 12);
    agrees("Magic-4.5", 12);
}

#[test]
fn bricks_are_those_of_cycles() {
    agrees("Brick", 5);
}

#[test]
fn checkers_are_those_of_cycles() {
    agrees("Checker", 3);
}

#[test]
fn gradients_are_those_of_cycles() {
    agrees("Gradient", 7);
}

#[test]
fn voronoi_cells_are_those_of_cycles() {
    agrees("Voronoi", 75);
    agrees("Voronoi-4.5", 75);
}

#[test]
fn gabor_noise_is_that_of_cycles() {
    agrees("Gabor", 8);
}

#[test]
fn menus_know_their_identifiers() {
    for noise_type in NoiseType::ALL {
        assert_eq!(NoiseType::from_name(noise_type.name()), Some(*noise_type));
    }
    assert_eq!(
        NoiseType::from_name("RIDGED_MULTIFRACTAL"),
        Some(NoiseType::RidgedMultifractal)
    );
    assert_eq!(NoiseType::from_name("fbm"), None);
    assert_eq!(Dimensions::from_name("4D"), Some(Dimensions::Four));
}

#[test]
fn no_number_makes_a_node_panic_or_take_long() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        -3e9,
        -0.0,
        1e9,
    ];
    for x in odd {
        let vector = Vec3::new(x, -x, 1.0);
        for noise_type in NoiseType::ALL {
            let inputs = NoiseInputs {
                vector,
                w: x,
                detail: x,
                distortion: x,
                offset: x,
                ..Default::default()
            };
            for dimensions in ["1D", "2D", "3D", "4D"] {
                let settings = NoiseSettings {
                    dimensions: Dimensions::from_name(dimensions).unwrap(),
                    noise_type: *noise_type,
                    normalize: true,
                };
                noise(&settings, &inputs);
            }
        }
        let inputs = WaveInputs {
            vector,
            distortion: 1.0,
            detail: x,
            ..Default::default()
        };
        let settings = WaveSettings {
            wave_type: WaveType::Rings,
            bands_direction: WaveBandsDirection::X,
            rings_direction: WaveRingsDirection::Spherical,
            profile: WaveProfile::Saw,
        };
        wave(&settings, &inputs);
        magic(
            MagicSettings::of(CyclesVersion::LATEST, 255),
            &MagicInputs {
                vector,
                distortion: x,
                ..Default::default()
            },
        );
        let inputs = BrickInputs {
            vector,
            row_height: 0.0,
            brick_width: x,
            ..Default::default()
        };
        brick(
            &BrickSettings {
                offset_frequency: 255,
                squash_frequency: 1,
                ..Default::default()
            },
            &inputs,
        );
        checker(&CheckerInputs {
            vector,
            scale: x,
            ..Default::default()
        });
        for gradient_type in GradientType::ALL {
            gradient(*gradient_type, vector);
        }
        for feature in VoronoiFeature::ALL {
            let inputs = VoronoiInputs {
                vector,
                w: x,
                detail: x,
                exponent: x,
                ..Default::default()
            };
            for dimensions in ["1D", "2D", "3D", "4D"] {
                let settings = VoronoiSettings {
                    dimensions: Dimensions::from_name(dimensions).unwrap(),
                    feature: *feature,
                    metric: VoronoiMetric::Minkowski,
                    normalize: true,
                    hash: VoronoiHash::Pcg,
                };
                voronoi(&settings, &inputs);
                let hash = VoronoiHash::Lookup3;
                voronoi(&VoronoiSettings { hash, ..settings }, &inputs);
            }
        }
        for gabor_type in GaborType::ALL {
            let inputs = GaborInputs {
                vector,
                frequency: x,
                orientation_3d: vector,
                ..Default::default()
            };
            gabor(*gabor_type, &inputs);
        }
    }
}
