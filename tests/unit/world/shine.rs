use super::*;
use crate::light::program::LookingRay;
use crate::scene::RayKind;
use crate::scene::graph::Node;
use crate::scene::graph::node::emission;
use glam::{DAffine3, DQuat, Mat3};

/// A tree whose emission is what is known of a place.
fn graph(input: PlaceInput) -> Graph {
    let mut graph = Graph::default();
    let place = graph.add(Node::new(NodeKind::Function(Function::Place(input))));
    let shines = Node::new(NodeKind::Emission).with(emission::COLOR, place);
    graph.surface = Some(graph.add(shines));
    graph
}

/// A camera at (1, 2, 3) that looks along −X.
fn view() -> View {
    let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let place = DAffine3::from_rotation_translation(turn, DVec3::new(1.0, 2.0, 3.0));
    let camera = crate::selftest::kit::camera(DVec3::ZERO, 1.0);
    let camera = crate::scene::Camera {
        world_from_camera: place,
        ..camera
    };
    View::new(&camera, (1.0, 1), DVec3::ZERO)
}

fn shown(input: PlaceInput, light: Option<LightAxes>, at: &ShinePoint) -> Vec3 {
    let known = (DVec3::ZERO, view());
    Shine::new(&Scene::default(), &graph(input), light, known).emitted(at)
}

#[test]
fn the_world_knows_directions_and_the_ray() {
    let direction = Vec3::new(0.6, 0.8, 0.0);
    let of = |input| {
        let ray = LookingRay {
            kind: RayKind::Glossy.bit(),
            depth: 3,
        };
        shown(input, None, &ShinePoint::around(direction, ray))
    };
    let blender = Vec3::new(0.6, 0.0, 0.8);
    for input in [
        PlaceInput::Generated,
        PlaceInput::Position,
        PlaceInput::Object,
    ] {
        assert_eq!(of(input), blender, "{input:?}");
    }
    for input in [
        PlaceInput::Normal,
        PlaceInput::Incoming,
        PlaceInput::ObjectNormal,
    ] {
        assert_eq!(of(input), -blender, "{input:?}");
    }
    // The camera's axes without its place: ahead is −X.
    let seen = of(PlaceInput::Camera);
    assert!((seen - Vec3::new(0.0, 0.8, -0.6)).length() < 1e-6, "{seen}");
    assert_eq!(of(PlaceInput::IsRay(RayKind::Glossy.bit())), Vec3::ONE);
    assert_eq!(of(PlaceInput::IsRay(RayKind::Camera.bit())), Vec3::ZERO);
    assert_eq!(of(PlaceInput::RayDepth), Vec3::splat(3.0));
}

#[test]
fn a_lamp_knows_its_own_axes() {
    let axes = LightAxes {
        light_from_world: Mat3::from_diagonal(Vec3::new(0.5, 1.0, 1.0)),
        location: Vec3::new(1.0, 0.0, 0.0),
        size: Vec2::ONE,
    };
    let at = ShinePoint {
        position: Vec3::new(3.0, 1.0, 0.0),
        normal: Vec3::Y,
        incoming: Vec3::X,
        uv: Vec2::new(0.25, 0.75),
        distance: 2.0,
        ray: LookingRay::sampling(0),
    };
    let of = |input| shown(input, Some(axes), &at);
    assert_eq!(of(PlaceInput::Object), Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(of(PlaceInput::ObjectNormal), Vec3::Y);
    assert_eq!(of(PlaceInput::Uv(0)), Vec3::new(0.25, 0.75, 0.0));
    assert_eq!(of(PlaceInput::Position), Vec3::new(3.0, 0.0, 1.0));
    assert_eq!(of(PlaceInput::RayLength), Vec3::splat(2.0));
    assert_eq!(of(PlaceInput::ObjectLocation), Vec3::X);
}

#[test]
fn trees_that_ask_for_the_camera_are_known() {
    assert!(asks_about_view(&graph(PlaceInput::Camera)));
    assert!(!asks_about_view(&graph(PlaceInput::Generated)));
}
