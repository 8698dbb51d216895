//! A scene that calls for every procedural texture.

use glam::{DAffine3, DQuat, DVec3};
use sundog::nodes::voronoi::{VoronoiFeature, VoronoiHash, VoronoiMetric};
use sundog::nodes::wave::{WaveBandsDirection, WaveProfile, WaveRingsDirection, WaveType};
use sundog::nodes::{
    BrickSettings, CyclesVersion, Dimensions, GaborType, GradientType, MagicSettings,
    NoiseSettings, NoiseType, VoronoiSettings, WaveSettings,
};
use sundog::scene::graph::function::{PlaceInput, VoronoiPart};
use sundog::scene::graph::node::diffuse;
use sundog::scene::graph::{Function, Graph, Node, NodeKind, ProceduralTexture};
use sundog::scene::{Material, Scene};
use sundog::selftest::kit::{camera, constant_environment, place, sphere};

/// A ball for each texture, under a constant sky.
pub fn scene() -> Scene {
    let textures = [
        ProceduralTexture::Noise(NoiseSettings {
            dimensions: Dimensions::Three,
            noise_type: NoiseType::Fbm,
            normalize: true,
        }),
        ProceduralTexture::Voronoi {
            settings: VoronoiSettings {
                dimensions: Dimensions::Three,
                feature: VoronoiFeature::F1,
                metric: VoronoiMetric::Euclidean,
                normalize: false,
                hash: VoronoiHash::Pcg,
            },
            part: VoronoiPart::Color,
        },
        ProceduralTexture::Wave(WaveSettings {
            wave_type: WaveType::Bands,
            bands_direction: WaveBandsDirection::X,
            rings_direction: WaveRingsDirection::X,
            profile: WaveProfile::Sin,
        }),
        ProceduralTexture::Magic(MagicSettings::of(CyclesVersion::LATEST, 2)),
        ProceduralTexture::Brick(BrickSettings::default()),
        ProceduralTexture::Checker,
        ProceduralTexture::Gradient(GradientType::Linear),
        ProceduralTexture::WhiteNoise(Dimensions::Three),
        ProceduralTexture::Gabor(GaborType::ThreeD),
    ];
    let mut scene = Scene {
        environment: constant_environment(0.7),
        ..Scene::default()
    };
    scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
    for (number, texture) in textures.into_iter().enumerate() {
        let mut graph = Graph::default();
        let coordinates = NodeKind::Function(Function::Place(PlaceInput::Object));
        let coordinates = graph.add(Node::new(coordinates));
        let pattern = Node::new(NodeKind::Function(Function::Texture(texture)));
        let pattern = graph.add(pattern.with(0, coordinates));
        let surface = Node::new(NodeKind::DiffuseBsdf {
            rules: Default::default(),
        })
        .with(diffuse::COLOR, pattern);
        graph.surface = Some(graph.add(surface));
        let material = Material {
            name: format!("pattern {number}"),
            graph,
            double_sided: true,
            medium: None,
            priority: None,
        };
        let at = DVec3::new((number % 3) as f64 - 1.0, (number / 3) as f64 - 1.0, 0.0);
        let at = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, at);
        place(&mut scene, sphere(12, 0.0, true), material, &[at]);
    }
    scene
}
