use super::*;
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::function::{self, PlaceInput, Space, Transformed};
use crate::scene::graph::node::{
    diffuse, emission, glossy, math, mix_shader, principled, transparent,
};
use crate::scene::graph::{Distribution, Graph, Input, Link, Node, NodeKind};
use crate::scene::{
    AlphaMode, Image, ImageId, ImageUse, Material, MetallicRoughness, NormalTexture, Texture,
};
use crate::shading::Principled;
use crate::shading::texture::Raster;
use std::cell::Cell;
use std::sync::Arc;

/// Images of one texel.
struct Texels(Vec<[f32; 4]>);

impl Source for Texels {
    fn texture(&mut self, texture: &Texture, usage: ImageUse) -> Option<PreparedTexture> {
        let texel = self.0.get(texture.image.0 as usize)?;
        let image = Image {
            name: "texel".into(),
            width: 1,
            height: 1,
            channels: 4,
            pixels: texel.to_vec().into(),
        };
        let raster = Raster::new(&image, texture.sampler.alpha);
        let space = WorkingSpace::default();
        Some(PreparedTexture::new(
            texture,
            Arc::new(raster),
            usage,
            space,
        ))
    }
}

/// Counts look-ups.
#[derive(Default)]
struct Here {
    read: Cell<usize>,
    at: Vec3,
}

impl Place for Here {
    fn input(&self, input: PlaceInput) -> Vec4 {
        match input {
            PlaceInput::Generated => self.at.extend(1.0),
            PlaceInput::Incoming => Vec3::Z.extend(1.0),
            _ => Vec4::ZERO,
        }
    }
    fn transformed(&self, v: Vec3, _: Transformed, _: Space, _: Space) -> Vec3 {
        v
    }
    fn facing(&self, outside: Vec3) -> Vec3 {
        if outside == Vec3::ZERO {
            Vec3::Z
        } else {
            outside
        }
    }
    fn outside(&self, facing: Vec3) -> Vec3 {
        facing
    }
    fn steps(&self, pixels: f32) -> [Vec3; 2] {
        [Vec3::X * pixels, Vec3::Y * pixels]
    }
    fn of_neighbours(&self, steps: [Vec3; 2], mut number: impl FnMut(&Self) -> f32) -> [f32; 2] {
        steps.map(|step| {
            number(&Self {
                at: self.at + step,
                read: self.read.clone(),
            })
        })
    }
    fn undisplaced(&self, _: u32, _: bool) -> Self {
        Self {
            at: self.at,
            read: self.read.clone(),
        }
    }
    fn openness(&self, _: Vec3, _: f32, _: Openness) -> f32 {
        0.25
    }
    fn beveled(&self, _: f32, _: u8) -> Vec3 {
        Vec3::Z
    }
    fn met(&self, _: (Vec3, Vec3, f32), _: bool) -> Option<Met> {
        None
    }
    fn is_on_edge(&self, _: f32, _: bool) -> bool {
        false
    }
    fn uv(&self, _: u32) -> Vec2 {
        self.read.set(self.read.get() + 1);
        Vec2::splat(0.5)
    }

    fn color(&self) -> Vec4 {
        Vec4::new(0.5, 1.0, 1.0, 0.75)
    }

    fn mapped_normal(&self, _: NormalSpace, tangent_space: Vec3, strength: f32) -> Vec3 {
        tangent_space * strength
    }
}

const COLORED: Known = Known {
    space: WorkingSpace::Rec709,
    vertex_colors: true,
};
const PLAIN: Known = Known {
    space: WorkingSpace::Rec709,
    vertex_colors: false,
};

fn texture(number: u32) -> Option<Texture> {
    Some(ImageId(number).into())
}

fn compiled(m: MetallicRoughness, known: Known, texels: &[[f32; 4]]) -> Programs {
    let graph = Material::from(m).graph;
    compile(&graph, known, &mut Texels(texels.to_vec()))
}

fn parameters_of(programs: &Programs, here: &Here) -> Principled {
    let Shader::Principled { base, linked, .. } = &programs.shaders[0].shader else {
        panic!("{programs:?}");
    };
    programs.surface.at(here, |at| parameters(base, linked, at))
}

#[test]
fn a_constant_material_has_no_operations() {
    let programs = compiled(
        MetallicRoughness {
            base_color: [0.1, 0.2, 0.3],
            metallic: 0.25,
            roughness: 0.75,
            specular: 0.6,
            emission: [3.0, 2.0, 1.0],
            alpha: 0.4,
            alpha_mode: AlphaMode::Blend,
            ..MetallicRoughness::default()
        },
        PLAIN,
        &[],
    );
    assert!(programs.surface.is_empty() && programs.emission.program.is_empty());
    let p = parameters_of(&programs, &Here::default());
    assert_eq!(p.base_color, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((p.metallic, p.roughness, p.specular), (0.25, 0.75, 0.6));
    assert_eq!(programs.emission.constant(), Some(Vec3::new(3.0, 2.0, 1.0)));
    let opacity = programs.opacity.unwrap();
    assert!(opacity.program.is_empty());
    assert_eq!(opacity.rest.constant(), Some(Vec3::splat(0.4)));
    assert_eq!(
        opacity.transmittance.constant(),
        Some(Vec3::splat(1.0 - 0.4))
    );
}

#[test]
fn channels_factors_and_vertices_are_multiplied_as_gltf_says() {
    let texels = [
        [0.5, 0.25, -0.125, 0.5],
        [9.0, 0.5, 0.75, 9.0],
        [0.5, 0.75, 1.0, 1.0],
    ];
    let m = MetallicRoughness {
        base_color: [0.5, 0.5, 1.0],
        base_color_texture: texture(0),
        metallic: 0.5,
        roughness: 0.25,
        metallic_roughness_texture: texture(1),
        specular: 0.5,
        specular_texture: texture(0),
        normal_texture: Some(NormalTexture {
            texture: ImageId(2).into(),
            scale: 2.0,
        }),
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..MetallicRoughness::default()
    };
    let programs = compiled(m.clone(), COLORED, &texels);
    let here = Here::default();
    let p = parameters_of(&programs, &here);
    // Red: factor, vertex, texel; below 0 nothing is reflected.
    assert_eq!(p.base_color, Vec3::new(0.5 * 0.5 * 0.5, 0.5 * 0.25, 0.0));
    assert_eq!((p.metallic, p.roughness), (0.5 * 0.75, 0.25 * 0.5));
    assert_eq!(p.specular, 0.5 * 0.5);
    // Base colour, metal and roughness at once, the specular strength; not the normal map.
    assert_eq!(here.read.get(), 3);
    let normal = *programs.shaders[0].shader.normal().unwrap();
    let normal = programs.surface.at(&here, |at| at.color(&normal));
    assert_eq!(normal, Vec3::new(0.0, 1.0, 2.0));
    assert_eq!(here.read.get(), 4);
    // Shadow rays read the opacity alone.
    let opacity = programs.opacity.unwrap();
    let here = Here::default();
    let rest = opacity.program.at(&here, |at| at.number(&opacity.rest));
    assert_eq!(rest, 0.5 * 0.75 * 0.5);
    assert_eq!(here.read.get(), 1);
    let clear = opacity
        .program
        .at(&here, |at| at.color(&opacity.transmittance));
    assert_eq!(clear, Vec3::splat(1.0 - rest));

    let clip = |cutoff| {
        let alpha_mode = AlphaMode::Mask { cutoff };
        let m = MetallicRoughness {
            alpha_mode,
            ..m.clone()
        };
        let opacity = compiled(m, COLORED, &texels).opacity.unwrap();
        opacity.program.at(&here, |at| at.number(&opacity.rest))
    };
    assert_eq!((clip(0.1875), clip(0.19)), (1.0, 0.0));
}

#[test]
fn a_metal_does_not_read_what_it_hides() {
    let m = |metallic| MetallicRoughness {
        metallic,
        metallic_roughness_texture: texture(0),
        transmission: 0.5,
        transmission_texture: texture(1),
        specular_color_texture: texture(1),
        ..MetallicRoughness::default()
    };
    let texels = [[1.0; 4], [0.5; 4]];
    for (metallic, read) in [(1.0, 1), (0.5, 3)] {
        let programs = compiled(m(metallic), PLAIN, &texels);
        let here = Here::default();
        let p = parameters_of(&programs, &here);
        assert_eq!((p.metallic, here.read.get()), (metallic, read));
        assert_eq!(p.transmission, if metallic < 1.0 { 0.25 } else { 0.0 });
    }
}

#[test]
fn an_unlit_surface_shines_with_its_colour() {
    let m = MetallicRoughness {
        unlit: true,
        base_color: [2.0, 1.0, 0.5],
        base_color_texture: texture(0),
        ..MetallicRoughness::default()
    };
    let programs = compiled(m, COLORED, &[[0.5, -1.0, 1.0, 1.0]]);
    assert!(programs.shaders.is_empty() && programs.opacity.is_none());
    let emitted = |at: &mut Evaluation<'_, Here>| at.color(&programs.emission.shining.open);
    let light = programs.emission.program.at(&Here::default(), emitted);
    assert_eq!(light, Vec3::new(0.5, -1.0, 0.5));
}

fn calculation(operation: MathOperation, a: impl Into<Input>, b: impl Into<Input>) -> Node {
    let clamp = false;
    let node = Node::new(NodeKind::Math { operation, clamp });
    node.with(math::A, a).with(math::B, b)
}

#[test]
fn mixes_and_sums_of_shaders_are_a_list_with_weights() {
    let mut graph = Graph::default();
    let alpha = graph.add(Node::new(NodeKind::ColorAttribute));
    let alpha = Link { output: 1, ..alpha };
    let matte = graph.add(
        Node::new(NodeKind::DiffuseBsdf {
            rules: Default::default(),
        })
        .with(diffuse::COLOR, [0.25; 3]),
    );
    let distribution = Distribution::Ggx;
    let shiny = Node::new(NodeKind::GlossyBsdf { distribution }).with(glossy::ROUGHNESS, 0.125);
    let shiny = graph.add(shiny);
    let lamp = Node::new(NodeKind::Emission)
        .with(emission::COLOR, [1.0, 0.5, 0.25])
        .with(emission::STRENGTH, 4.0);
    let lamp = graph.add(lamp);
    let glass = Node::new(NodeKind::TransparentBsdf).with(transparent::COLOR, [1.0, 0.5, 0.0]);
    let glass = graph.add(glass);
    let mixed = |graph: &mut Graph, factor: Input, a: Link, b: Link| {
        let node = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, factor);
        graph.add(node.with(mix_shader::A, a).with(mix_shader::B, b))
    };
    let scattering = mixed(&mut graph, alpha.into(), matte, shiny);
    let sum = graph.add(
        Node::new(NodeKind::AddShader)
            .with(0, scattering)
            .with(1, lamp),
    );
    graph.surface = Some(mixed(&mut graph, 0.25.into(), sum, glass));
    let programs = compile(&graph, COLORED, &mut Texels(Vec::new()));
    let here = Here::default();
    let weights: Vec<f32> = programs
        .shaders
        .iter()
        .map(|s| programs.surface.at(&here, |at| at.number(&s.weight)))
        .collect();
    // Of what does not pass straight on; the vertex says 0.75.
    assert_eq!(weights, [0.25, 0.75]);
    assert!(matches!(programs.shaders[0].shader, Shader::Diffuse { .. }));
    let Shader::Glossy { roughness, .. } = &programs.shaders[1].shader else {
        panic!("{programs:?}");
    };
    assert_eq!(roughness.constant(), Some(Vec3::splat(0.125)));
    let emitted = programs.emission.constant();
    assert_eq!(emitted, Some(Vec3::new(4.0, 2.0, 1.0)));
    let opacity = programs.opacity.unwrap();
    let passes = opacity.transmittance.constant();
    assert_eq!(passes, Some(Vec3::new(0.25, 0.125, 0.0)));
}

/// A lamp and a matte surface of an image's colour, mixed by another image or by halves.
fn sign(mixed_by_an_image: bool) -> Programs {
    let mut graph = Graph::default();
    let mut image = |number: u32| {
        graph.add(Node::new(NodeKind::ImageTexture {
            texture: ImageId(number).into(),
            usage: ImageUse::Data,
            projection: Default::default(),
        }))
    };
    let (mask, color) = (image(0), image(1));
    let rules = Default::default();
    let matte = Node::new(NodeKind::DiffuseBsdf { rules }).with(diffuse::COLOR, color);
    let lamp = Node::new(NodeKind::Emission).with(emission::STRENGTH, 2.0);
    let (matte, lamp) = (
        graph.add(matte),
        graph.add(lamp.with(emission::COLOR, [1.0; 3])),
    );
    let factor: Input = if mixed_by_an_image {
        mask.into()
    } else {
        0.5.into()
    };
    let mix = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, factor);
    let mix = mix.with(mix_shader::A, matte).with(mix_shader::B, lamp);
    graph.surface = Some(graph.add(mix));
    let texels = vec![[0.25, 0.25, 0.25, 1.0], [0.5; 4]];
    compile(&graph, PLAIN, &mut Texels(texels))
}

#[test]
fn what_mixes_a_lamp_with_what_scatters_is_computed_once() {
    let programs = sign(true);
    let shining = programs.shining.as_ref().expect("a mask for both");
    let (apart, here) = (Here::default(), Here::default());
    let emission = &programs.emission;
    let alone = emission
        .program
        .at(&apart, |at| at.color(&emission.shining.open));
    let mut computed = Computed::default();
    let surface = &programs.surface;
    let light = surface.again(&here, &mut computed, |at| at.color(&shining.open));
    assert_eq!((light, light.x), (alone, 0.5));
    assert_eq!((apart.read.get(), here.read.get()), (1, 1));
    let weight = &programs.shaders[0].weight;
    let weight = surface.again(&here, &mut computed, |at| at.number(weight));
    assert_eq!((weight, here.read.get()), (0.75, 1));
    // Nothing is shared: what shines is the same everywhere.
    assert!(sign(false).shining.is_none());
}

#[test]
fn programs_of_any_length_run_what_a_socket_needs_and_no_more() {
    for length in [3usize, 20, 63, 64, 65, 130, 1000] {
        let mut graph = Graph::default();
        let image = |graph: &mut Graph| {
            graph.add(Node::new(NodeKind::ImageTexture {
                texture: ImageId(0).into(),
                usage: ImageUse::Data,
                projection: Default::default(),
            }))
        };
        let rough = image(&mut graph);
        let mut sum = Link { output: 1, ..rough };
        for _ in 0..length {
            sum = graph.add(calculation(MathOperation::Add, sum, 1.0));
        }
        let metal = Link {
            output: 1,
            ..image(&mut graph)
        };
        let node = Node::new(NodeKind::PrincipledBsdf {
            thin_wall: false,
            edge_tint: false,
            once: false,
            pane: false,
            walk: None,
            rules: Default::default(),
        })
        .with(principled::ROUGHNESS, sum)
        .with(principled::METALLIC, metal);
        graph.surface = Some(graph.add(node));
        let programs = compile(&graph, PLAIN, &mut Texels(vec![[0.0, 0.0, 0.0, 0.5]]));
        assert_eq!(programs.surface.len(), length + 2);
        let Shader::Principled { linked, .. } = &programs.shaders[0].shader else {
            panic!("{programs:?}");
        };
        let here = Here::default();
        let (metallic, read, roughness) = programs.surface.at(&here, |at| {
            let metallic = at.number(&linked[0].1);
            let read = here.read.get();
            (metallic, read, at.number(&linked[1].1))
        });
        assert_eq!((metallic, roughness), (0.5, 0.5 + length as f32));
        // In long programs a few operations go together.
        assert!(read == 1 || length > 62, "{length}: {read}");
        assert_eq!(here.read.get(), 2);
    }
}

/// A Bump over the sum of the coordinates, whose height colours the surface too.
fn raised(undisplaced: Option<u32>) -> Programs {
    let mut graph = Graph::default();
    let place = Function::Place(PlaceInput::Generated);
    let place = graph.add(Node::new(NodeKind::Function(place)));
    let height = graph.add(calculation(MathOperation::Multiply, place, place));
    let bump = Function::Bump {
        invert: false,
        object_space: false,
        undisplaced,
        is_of_5: false,
        widened: false,
    };
    let bump = Node::new(NodeKind::Function(bump)).with(function::bump::HEIGHT, height);
    let normal = graph.add(bump);
    let matte = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    })
    .with(diffuse::COLOR, height);
    graph.surface = Some(graph.add(matte.with(diffuse::NORMAL, normal)));
    compile(&graph, PLAIN, &mut Texels(Vec::new()))
}

fn normal_of(programs: &Programs, here: &Here) -> Vec3 {
    let normal = programs.shaders[0].shader.normal().unwrap();
    programs.surface.at(here, |at| at.color(normal))
}

#[test]
fn a_bump_takes_the_height_here_from_its_own_program() {
    let here = Here {
        at: Vec3::new(0.5, -0.25, 2.0),
        ..Here::default()
    };
    let mut programs = raised(None);
    // The place, the height and the bump: the surface's colour and the bump share the height.
    assert_eq!(programs.surface.len(), 3);
    let normal = normal_of(&programs, &here);
    assert!(normal.dot(Vec3::Z) < 0.999, "{normal}");
    let heights = programs.surface.calls.iter_mut();
    for height in heights.filter_map(|call| call.height.as_deref_mut()) {
        assert!(height.is_known_here);
        height.is_known_here = false;
    }
    assert_eq!(normal_of(&programs, &here), normal);
}

#[test]
fn a_bump_of_the_undisplaced_surface_evaluates_its_height_there() {
    let programs = raised(Some(0));
    let mut heights = programs.surface.calls.iter().filter_map(Call::height);
    assert!(heights.all(|height| !height.is_known_here));
}

/// What nodes give where the generated coordinates are (0.5, −0.25, 2), as an emitted colour.
fn computed(
    nodes: impl FnOnce(&mut dyn FnMut(Function, Vec<Input>) -> Link, Link) -> Link,
) -> Vec3 {
    let mut graph = Graph::default();
    let place = Function::Place(PlaceInput::Generated);
    let place = graph.add(Node::new(NodeKind::Function(place)));
    let mut add = |function: Function, inputs: Vec<Input>| {
        let mut node = Node::new(NodeKind::Function(function));
        node.inputs = inputs;
        graph.add(node)
    };
    let result = nodes(&mut add, place);
    let lamp = Node::new(NodeKind::Emission).with(emission::COLOR, result);
    graph.surface = Some(graph.add(lamp.with(emission::STRENGTH, 1.0)));
    let programs = compile(&graph, PLAIN, &mut Texels(Vec::new()));
    let here = Here {
        at: Vec3::new(0.5, -0.25, 2.0),
        ..Here::default()
    };
    let light = &programs.emission;
    light.program.at(&here, |at| at.color(&light.shining.open))
}

#[test]
fn sockets_take_numbers_vectors_and_constants_as_what_they_are() {
    use crate::nodes::vector_math::VectorMath;
    let added = computed(|add, place| {
        let inputs = vec![
            place.into(),
            [1.0, 2.0, 3.0].into(),
            Input::None,
            Input::None,
        ];
        add(Function::VectorMath(VectorMath::Add), inputs)
    });
    assert_eq!(added, Vec3::new(1.5, 1.75, 5.0));
    // A number of a vector is the mean of its coordinates, and stands in all places of a colour.
    let half = |of: Link| vec![0.5.into(), of.into(), 1.0.into()];
    let mixed = computed(|add, place| add(Function::MixFloat { clamp: true }, half(place)));
    assert_eq!(mixed, Vec3::splat(0.875));
    // That of a colour is its luminance.
    let grey = computed(|add, place| {
        let colour = add(Function::Invert, vec![0.0.into(), place.into()]);
        add(Function::MixFloat { clamp: true }, half(colour))
    });
    let expected = 0.5 * luminance(Vec3::new(0.5, -0.25, 2.0)) + 0.5;
    assert!((grey.x - expected).abs() < 1e-6, "{grey} {expected}");
}

/// A vector of no length is at right angles to the view, as in Cycles; without a link the surface's own normal counts.
#[test]
fn a_vector_of_no_length_is_no_missing_normal() {
    let nothing = |add: &mut dyn FnMut(Function, Vec<Input>) -> Link, place: Link| {
        let inputs = vec![place.into(), [0.0; 3].into(), Input::None, Input::None];
        add(
            Function::VectorMath(crate::nodes::vector_math::VectorMath::Multiply),
            inputs,
        )
    };
    let of_nothing = computed(|add, place| {
        let normal = nothing(add, place);
        add(Function::Fresnel, vec![1.5.into(), normal.into()])
    });
    assert_eq!(of_nothing, Vec3::ONE);
    let own = computed(|add, _| add(Function::Fresnel, vec![1.5.into(), Input::None]));
    assert!((own.x - 0.04).abs() < 1e-6, "{own}");
    // Rays that go nowhere meet nothing.
    let kind = Function::AmbientOcclusion {
        samples: 4,
        inside: false,
        only_local: false,
    };
    let open = computed(|add, place| {
        let normal = nothing(add, place);
        add(kind, vec![[0.5; 3].into(), 1.0.into(), normal.into()])
    });
    assert_eq!(open, Vec3::splat(0.5));
}

#[test]
fn a_mapping_that_changes_nothing_is_no_operation() {
    use crate::nodes::vector::Mapping;
    let mapped = |location: f32, kind: Mapping| {
        let mut graph = Graph::default();
        let place = Function::Place(PlaceInput::Generated);
        let place = graph.add(Node::new(NodeKind::Function(place)));
        let mut node = Node::new(NodeKind::Function(Function::Mapping(kind)));
        node.inputs = vec![
            place.into(),
            [location; 3].into(),
            [0.0; 3].into(),
            [1.0; 3].into(),
        ];
        let mapping = graph.add(node);
        let lamp = Node::new(NodeKind::Emission).with(emission::COLOR, mapping);
        graph.surface = Some(graph.add(lamp.with(emission::STRENGTH, 1.0)));
        let programs = compile(&graph, PLAIN, &mut Texels(Vec::new()));
        programs.emission.program.len()
    };
    for kind in [Mapping::Point, Mapping::Texture, Mapping::Vector] {
        assert_eq!(mapped(0.0, kind), 1, "{kind:?}");
    }
    assert_eq!(mapped(0.5, Mapping::Point), 2);
    // Normals become unit vectors.
    assert_eq!(mapped(0.0, Mapping::Normal), 2);
}
