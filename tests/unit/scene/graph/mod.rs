use super::function::{PlaceInput, bump};
use super::node::{emission, math, mix, mix_shader, normal_map, principled, separate};
use super::*;
use crate::nodes::vector::Mapping;
use crate::nodes::vector_math::VectorMath;
use crate::scene::{ImageId, ImageUse};
use glam::Vec4;

/// Image 0 is red everywhere with an opacity of 0.6 or more, image 1 is anything, image 2 may not be finite.
struct Known;

impl Facts for Known {
    fn image(&mut self, texture: &Texture, _: ImageUse, _: [bool; 4]) -> Range {
        match texture.image.0 {
            0 => Range {
                low: Vec4::new(1.0, 0.0, 0.0, 0.6),
                high: Vec4::new(1.0, 0.0, 0.0, 1.0),
            },
            1 => Range::SHARE,
            _ => Range::UNKNOWN,
        }
    }

    fn colors(&self) -> Range {
        Range::WHITE
    }
}

fn image(graph: &mut Graph, number: u32) -> Link {
    graph.add(Node::new(NodeKind::ImageTexture {
        texture: ImageId(number).into(),
        usage: ImageUse::Color,
        projection: Default::default(),
    }))
}

fn calculation(operation: MathOperation, a: impl Into<Input>, b: impl Into<Input>) -> Node {
    let clamp = false;
    let node = Node::new(NodeKind::Math { operation, clamp });
    node.with(math::A, a).with(math::B, b)
}

fn blend(blend: Blend, factor: f32, a: impl Into<Input>, b: impl Into<Input>) -> Node {
    let node = Node::new(NodeKind::MixColor { blend }).with(mix::FACTOR, factor);
    node.with(mix::A, a).with(mix::B, b)
}

fn surface() -> Node {
    Node::new(NodeKind::PrincipledBsdf {
        thin_wall: false,
        edge_tint: false,
        once: false,
        pane: false,
        walk: None,
        rules: Default::default(),
    })
}

fn folded(mut graph: Graph, surface: Node) -> Graph {
    graph.surface = Some(graph.add(surface));
    fold(&mut graph, &mut Known);
    graph
}

fn last(graph: &Graph) -> &Node {
    graph.node(graph.surface.unwrap())
}

#[test]
fn what_is_the_same_everywhere_becomes_a_value() {
    let mut graph = Graph::default();
    let red = image(&mut graph, 0);
    let colors = graph.add(Node::new(NodeKind::ColorAttribute));
    let tinted = graph.add(blend(Blend::Multiply, 1.0, [0.5, 0.25, 0.125], colors));
    let product = graph.add(blend(Blend::Multiply, 1.0, tinted, red));
    let channels = graph.add(Node::new(NodeKind::SeparateColor).with(separate::COLOR, red));
    let green = Link {
        output: node::GREEN,
        ..channels
    };
    let rough = graph.add(calculation(MathOperation::Add, 0.25, green));
    let graph = folded(
        graph,
        surface()
            .with(principled::BASE_COLOR, product)
            .with(principled::ROUGHNESS, rough),
    );
    assert_eq!(graph.nodes.len(), 1);
    let inputs = &last(&graph).inputs;
    assert_eq!(
        inputs[principled::BASE_COLOR],
        Input::Value([0.5, 0.0, 0.0])
    );
    assert_eq!(inputs[principled::ROUGHNESS], Input::float(0.25));
}

#[test]
fn what_folding_finds_comes_into_the_range_of_a_principled_bsdf() {
    let mut graph = Graph::default();
    let color = graph.add(
        Node::new(NodeKind::Function(Function::VectorMath(VectorMath::Add)))
            .with(0, [-0.5, 0.25, 100.0])
            .with(1, [0.25, 0.25, 100.0]),
    );
    let rough = graph.add(calculation(MathOperation::Add, 1.5, 1.0));
    let graph = folded(
        graph,
        surface()
            .with(principled::BASE_COLOR, color)
            .with(principled::ROUGHNESS, rough),
    );
    let inputs = &last(&graph).inputs;
    assert_eq!(
        inputs[principled::BASE_COLOR],
        Input::Value([0.0, 0.5, 100.0])
    );
    assert_eq!(inputs[principled::ROUGHNESS], Input::float(1.0));
}

/// What an Emission shows of a function of three numbers and a place that varies.
fn of_place(function: Function, inputs: &[(usize, [f32; 3])], varies: usize) -> Input {
    let mut graph = Graph::default();
    let place = graph.add(Node::new(NodeKind::Function(Function::Place(
        PlaceInput::Attribute(0),
    ))));
    let mut node = Node::new(NodeKind::Function(function)).with(varies, place);
    for (socket, value) in inputs {
        node = node.with(*socket, *value);
    }
    let made = graph.add(node);
    let graph = folded(
        graph,
        Node::new(NodeKind::Emission).with(emission::COLOR, made),
    );
    last(&graph).inputs[emission::COLOR]
}

#[test]
fn a_mapping_of_points_by_nothing_loses_its_location_as_in_cycles() {
    let inputs = [(1, [0.5, 0.25, 0.125]), (3, [0.0; 3])];
    let nothing = of_place(Function::Mapping(Mapping::Point), &inputs, 0);
    assert_eq!(nothing, Input::Value([0.0; 3]));
    let whole = [(1, [0.5, 0.25, 0.125]), (3, [1.0; 3])];
    assert!(
        of_place(Function::Mapping(Mapping::Point), &whole, 0)
            .link()
            .is_some()
    );
}

#[test]
fn the_numbers_of_an_image_that_something_takes_are_known() {
    let mut graph = Graph::default();
    let [base, metal, alone] = [0, 1, 2].map(|number| image(&mut graph, number));
    let channels = graph.add(Node::new(NodeKind::SeparateColor).with(separate::COLOR, metal));
    let output = |link: Link, output: u8| Link { output, ..link };
    let node = surface()
        .with(principled::BASE_COLOR, base)
        .with(principled::METALLIC, output(channels, node::BLUE))
        .with(principled::ROUGHNESS, output(channels, node::GREEN))
        .with(principled::TRANSMISSION_WEIGHT, output(alone, node::ALPHA));
    graph.surface = Some(graph.add(node));
    let taken = graph.taken();
    assert_eq!(taken[0], [true, true, true, false]);
    assert_eq!(taken[1], [false, true, true, false]);
    assert_eq!(taken[2], [false, false, false, true]);
}

#[test]
fn nothing_times_an_image_is_nothing_unless_that_may_be_infinite() {
    for (number, nodes) in [(1, 1), (2, 3)] {
        let mut graph = Graph::default();
        let any = image(&mut graph, number);
        let product = graph.add(blend(Blend::Multiply, 1.0, [0.0; 3], any));
        let graph = folded(graph, surface().with(principled::BASE_COLOR, product));
        assert_eq!(graph.nodes.len(), nodes, "image {number}");
    }
}

#[test]
fn factors_of_one_and_branches_of_no_weight_are_gone() {
    let mut graph = Graph::default();
    let any = image(&mut graph, 1);
    let other = image(&mut graph, 2);
    let kept = graph.add(blend(Blend::Mix, 0.0, any, other));
    let product = graph.add(blend(Blend::Multiply, 1.0, [1.0; 3], kept));
    let lamp = graph.add(Node::new(NodeKind::Emission).with(emission::COLOR, other));
    let base = graph.add(surface().with(principled::BASE_COLOR, product));
    let mixed = Node::new(NodeKind::MixShader)
        .with(mix_shader::FACTOR, 0.0)
        .with(mix_shader::A, base)
        .with(mix_shader::B, lamp);
    let graph = folded(graph, mixed);
    // The image and the surface.
    assert_eq!(graph.nodes.len(), 2);
    assert_eq!(
        last(&graph).inputs[principled::BASE_COLOR].link(),
        Some(any)
    );
}

#[test]
fn below_metal_and_glass_nothing_is_read_that_is_not_seen() {
    let with = |metallic: f32, transmission: f32, number: u32| {
        let mut graph = Graph::default();
        let any = image(&mut graph, number);
        let channel = |graph: &mut Graph, factor: f32| {
            let channels = Node::new(NodeKind::SeparateColor).with(separate::COLOR, any);
            let channel = graph.add(channels);
            graph.add(calculation(MathOperation::Multiply, factor, channel))
        };
        let level = channel(&mut graph, 0.375);
        let tint = graph.add(blend(Blend::Multiply, 1.0, [0.5; 3], any));
        let node = surface()
            .with(principled::METALLIC, metallic)
            .with(principled::SPECULAR_IOR_LEVEL, level)
            .with(principled::SPECULAR_TINT, tint)
            .with(principled::TRANSMISSION_WEIGHT, transmission);
        last(&folded(graph, node)).inputs.clone()
    };
    let linked = |inputs: &[Input]| {
        [principled::SPECULAR_IOR_LEVEL, principled::SPECULAR_TINT]
            .map(|socket| inputs[socket].link().is_some())
    };
    let metal = with(1.0, 0.0, 1);
    assert_eq!(linked(&metal), [false, false]);
    // The factors stay.
    assert_eq!(metal[principled::SPECULAR_IOR_LEVEL], Input::float(0.375));
    assert_eq!(metal[principled::SPECULAR_TINT], Input::Value([0.5; 3]));
    assert_eq!(linked(&with(0.9, 0.0, 1)), [true, true]);
    assert_eq!(linked(&with(0.0, 1.0, 1)), [false, true]);
    // What may not be finite stays.
    assert_eq!(linked(&with(1.0, 0.0, 2)), [true, true]);
}

#[test]
fn opacity_above_the_threshold_is_none() {
    let with = |cutoff: f32| {
        let mut graph = Graph::default();
        let alpha = Link {
            output: node::ALPHA,
            ..image(&mut graph, 0)
        };
        let hole = graph.add(calculation(MathOperation::LessThan, alpha, cutoff));
        let shown = graph.add(surface());
        let clear = graph.add(Node::new(NodeKind::TransparentBsdf));
        let mixed = Node::new(NodeKind::MixShader)
            .with(mix_shader::FACTOR, hole)
            .with(mix_shader::A, shown)
            .with(mix_shader::B, clear);
        folded(graph, mixed).summary(false).opacity
    };
    assert_eq!(with(0.5), Opacity::Full);
    let holes = |cutoff| Opacity::Clip {
        cutoff,
        holes: true,
    };
    // Roundings may turn 0.6.
    assert_eq!(with(0.6), holes(0.6));
    assert_eq!(with(0.8), holes(0.8));
    // All of it is a hole: what it would be is kept.
    assert_eq!(with(1.5), holes(1.5));
}

#[test]
fn normal_maps_of_no_strength_are_none() {
    for (strength, gone) in [(0.0, true), (0.5, false)] {
        let mut graph = Graph::default();
        let any = image(&mut graph, 1);
        let map = Node::new(NodeKind::NormalMap {
            space: Default::default(),
        })
        .with(normal_map::STRENGTH, strength)
        .with(normal_map::COLOR, any);
        let map = graph.add(map);
        let graph = folded(graph, surface().with(principled::NORMAL, map));
        assert_eq!(!graph.has_normal_map(), gone);
        assert_eq!(graph.textures().count(), usize::from(!gone));
    }
}

/// Numbers alone are ignored there, as in Cycles; an image is none, even one of a single colour.
#[test]
fn a_bump_that_raises_nothing_is_passed_by() {
    let with = |normal: fn(&mut Graph) -> Link, height: bool| {
        let mut graph = Graph::default();
        let normal = normal(&mut graph);
        let mut raised = Node::new(NodeKind::Function(Function::Bump {
            invert: false,
            object_space: false,
            undisplaced: None,
            is_of_5: true,
            widened: false,
        }))
        .with(bump::NORMAL, normal);
        if height {
            let any = image(&mut graph, 1);
            raised = raised.with(bump::HEIGHT, any);
        }
        let raised = graph.add(raised);
        let graph = folded(graph, surface().with(principled::NORMAL, raised));
        let normal = last(&graph).inputs[principled::NORMAL];
        normal.link().map(|link| graph.node(link).kind.clone())
    };
    let numbers =
        |graph: &mut Graph| graph.add(Node::new(NodeKind::Function(Function::CombineXyz)));
    let red = |graph: &mut Graph| image(graph, 0);
    assert_eq!(with(numbers, false), None);
    assert!(matches!(
        with(red, false),
        Some(NodeKind::ImageTexture { .. })
    ));
    for normal in [numbers, red] {
        let kind = with(normal, true);
        assert!(matches!(
            kind,
            Some(NodeKind::Function(Function::Bump { .. }))
        ));
    }
}

#[test]
fn an_image_goes_from_one_socket_alone() {
    let mut graph = Graph::default();
    let any = image(&mut graph, 1);
    let channels = graph.add(Node::new(NodeKind::SeparateColor).with(separate::COLOR, any));
    let tinted = graph.add(blend(Blend::Multiply, 1.0, [0.5; 3], any));
    let node = surface()
        .with(principled::BASE_COLOR, tinted)
        .with(principled::ROUGHNESS, channels);
    let at = graph.add(node);
    graph.surface = Some(at);
    graph.whiten(at.node as usize, principled::BASE_COLOR);
    assert!(!graph.has_texture(Slot::BaseColor));
    assert!(graph.has_texture(Slot::MetallicRoughness));
    let p = graph.summary(false).principled[0];
    assert_eq!(p.base_color.to_array(), [0.5; 3]);
    assert_eq!(p.roughness, (0.0, 1.0));
}

#[test]
fn links_that_go_nowhere_and_numbers_that_mean_nothing_are_mended() {
    let mut graph = Graph::default();
    let gone = image(&mut graph, 7);
    let there = image(&mut graph, 1);
    let factor = [f32::NAN, -1.0, f32::INFINITY];
    let product = graph.add(blend(Blend::Multiply, 1.0, factor, there));
    let lost = graph.add(blend(Blend::Multiply, 1.0, [0.5; 3], gone));
    let itself = Link {
        node: 4,
        output: node::ONLY,
    };
    let absurd = Link { output: 9, ..there };
    let node = surface()
        .with(principled::BASE_COLOR, product)
        .with(principled::SPECULAR_TINT, lost)
        .with(principled::METALLIC, itself)
        .with(principled::ROUGHNESS, absurd)
        .with(principled::IOR, 0.5);
    graph.surface = Some(graph.add(node));
    let faults = graph.clean(2);
    assert_eq!(
        faults,
        Faults {
            numbers: true,
            textures: true,
            links: true
        }
    );
    assert_eq!(graph.textures().count(), 1);
    let inputs = &last(&graph).inputs;
    assert_eq!(inputs[principled::METALLIC], Input::float(0.0));
    assert_eq!(inputs[principled::ROUGHNESS], Input::float(0.5));
    assert_eq!(inputs[principled::IOR], Input::float(0.5));
    // The factor of a base colour is brought into the range of base colours.
    let product = graph.node(inputs[principled::BASE_COLOR].link().unwrap());
    assert_eq!(product.inputs[mix::A], Input::Value([0.0, 0.0, 1.0]));
    assert_eq!(graph.clean(2), Faults::default());
}

/// By colours and strengths that are known, and the weights of mixes; what nodes compute counts as 1, their factors as one half.
#[test]
fn how_strongly_a_surface_seems_to_emit() {
    let mut graph = Graph::default();
    let computed = image(&mut graph, 1);
    let glow = |color: Input, strength: f32| {
        Node::new(NodeKind::Emission)
            .with(emission::COLOR, color)
            .with(emission::STRENGTH, strength)
    };
    let red = graph.add(glow(Input::Value([1.0, 0.5, 0.0]), 4.0));
    let textured = graph.add(glow(computed.into(), 2.0));
    let mix = |a: Link, b: Link| {
        Node::new(NodeKind::MixShader)
            .with(mix_shader::A, a)
            .with(mix_shader::B, b)
    };
    let plain = graph.add(surface());
    let quarter = graph.add(mix(plain, red).with(mix_shader::FACTOR, 0.25));
    let half = graph.add(mix(quarter, textured).with(mix_shader::FACTOR, computed));
    for (surface, expected) in [
        (plain, [0.0; 3]),
        (red, [4.0, 2.0, 0.0]),
        (quarter, [1.0, 0.5, 0.0]),
        (half, [1.5, 1.25, 1.0]),
    ] {
        graph.surface = Some(surface);
        assert_eq!(graph.emission_estimate().to_array(), expected);
    }
}
