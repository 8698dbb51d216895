//! Khronos' extensions of materials that are graphs of more than metal and roughness, and variants.

use super::kit::*;
use ::sundog::effects::EffectReport;
use ::sundog::import::{ImportOptions, Imported};
use ::sundog::scene::graph::node::{self, add_shader, mix_shader, principled};
use ::sundog::scene::graph::{Graph, Input, Node, NodeKind, SocketKind, Unit};
use ::sundog::scene::{Effect, Material};
use serde_json::{Value, json};

/// A square of one material, which loads without a word.
fn material(of: Value) -> Material {
    let mut file = Builder::square();
    file.json["materials"] = json!([of]);
    exact(&file)
}

fn exact(file: &Builder) -> Material {
    let imported = file.load();
    assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
    imported.scene.materials[0].clone()
}

/// A texture of one texel, and the file that has it.
fn textured(texel: [u8; 4]) -> (Builder, usize) {
    let mut file = Builder::square();
    let image = image::RgbaImage::from_pixel(1, 1, image::Rgba(texel));
    let texture = file.png_texture(image.into());
    (file, texture)
}

fn shader(graph: &Graph) -> &Node {
    graph.node(graph.body().unwrap())
}

/// The greatest that a socket can be, where images are white.
fn most(graph: &Graph, of: &Node, socket: usize) -> [f32; 3] {
    let results = graph.results(&mut Unit {
        vertex_alpha: false,
    });
    let kind = of.kind.sockets()[socket].kind;
    let range = graph.range_of(&results, of.inputs[socket], kind);
    range.high.truncate().to_array()
}

/// The images behind a socket.
fn images(graph: &Graph, of: &Node, socket: usize) -> Vec<u32> {
    let textures = graph.textures_behind(of.inputs[socket]);
    textures.map(|texture| texture.image.0).collect()
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn specular_and_glossiness_take_the_place_of_metal_and_roughness() {
    let extension = json!({
        "diffuseFactor": [0.5, 0.25, 0.125, 0.75],
        "specularFactor": [0.04, 0.5, 1.0],
        "glossinessFactor": 0.75
    });
    let of = material(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1], "roughnessFactor": 0.1 },
        "alphaMode": "BLEND",
        "extensions": { "KHR_materials_pbrSpecularGlossiness": extension }
    }));
    let m = standard(&of);
    assert_eq!(m.base_color, [0.5, 0.25, 0.125]);
    assert_eq!((m.alpha, m.metallic, m.roughness), (0.75, 0.0, 0.25));
    assert_eq!((m.ior, m.specular), (1.5, 1.0));
    // At normal incidence glass of 1.5 reflects 0.04.
    assert!(near(m.specular_color.map(|c| c * 0.04), [0.04, 0.5, 1.0]));
}

/// A reflection of 0.04 is that of the default material of glTF's core, when it is no metal.
#[test]
fn specular_and_glossiness_say_the_same_as_metal_and_roughness_where_both_can() {
    let glossy = standard(&material(json!({ "extensions": {
        "KHR_materials_pbrSpecularGlossiness": { "diffuseFactor": [0.5, 0.25, 1.0, 1.0],
            "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.5 } } })));
    let rough = standard(&material(json!({ "pbrMetallicRoughness": {
        "baseColorFactor": [0.5, 0.25, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5 } })));
    assert!(near(glossy.specular_color, rough.specular_color));
    let specular_color = rough.specular_color;
    let name = rough.name.clone();
    assert_eq!(
        ::sundog::scene::MetallicRoughness {
            specular_color,
            name,
            ..glossy
        },
        rough
    );
}

#[test]
fn glossiness_is_read_from_the_alpha_of_the_specular_image() {
    let (mut file, texture) = textured([255, 128, 0, 64]);
    let diffuse = file.png_texture(image::RgbaImage::new(2, 2).into());
    let fallback = file.png_texture(image::RgbaImage::new(3, 3).into());
    file.json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": fallback } },
        "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseTexture": { "index": diffuse },
            "specularGlossinessTexture": { "index": texture },
            "glossinessFactor": 0.5
        } }
    }]);
    let imported = file.load();
    let graph = &imported.scene.materials[0].graph;
    let of = shader(graph);
    let specular = images(graph, of, principled::SPECULAR_TINT);
    assert_eq!(images(graph, of, principled::ROUGHNESS), specular);
    assert_eq!(specular.len(), 1);
    assert_ne!(images(graph, of, principled::BASE_COLOR), specular);
    // The images of the fallback are not loaded.
    assert_eq!(imported.scene.images.len(), 2);
    // Roughness is 1 − 0.5 · alpha: from 0.5 to 1.
    let results = graph.results(&mut Unit {
        vertex_alpha: false,
    });
    let rough = graph.range_of(
        &results,
        of.inputs[principled::ROUGHNESS],
        SocketKind::Float,
    );
    assert_eq!(rough.number(), (0.5, 1.0));
    // Both sockets read one node.
    let nodes = graph.nodes.iter();
    let reads = nodes.filter(|n| matches!(n.kind, NodeKind::ImageTexture { .. }));
    assert_eq!(reads.count(), 2);
}

#[test]
fn what_must_not_stand_beside_specular_and_glossiness_is_left_out_and_told() {
    let mut file = Builder::square();
    file.json["materials"] = json!([{ "extensions": {
        "KHR_materials_pbrSpecularGlossiness": {},
        "KHR_materials_ior": { "ior": 2.0 },
        "KHR_materials_specular": { "specularFactor": 0.25 },
        "KHR_materials_iridescence": { "iridescenceFactor": 1.0 }
    } }]);
    let imported = file.load();
    assert_eq!(codes(&imported), ["beside-specular-glossiness"; 3]);
    let m = standard(&imported.scene.materials[0]);
    assert_eq!((m.ior, m.specular, m.thin_film), (1.5, 1.0, None));
    // What is unlit shows the base colour of the core.
    let unlit = standard(&material(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1.0] },
        "extensions": { "KHR_materials_unlit": {},
            "KHR_materials_pbrSpecularGlossiness": { "diffuseFactor": [1, 0, 0, 1] } }
    })));
    assert!(unlit.unlit);
    assert_eq!(unlit.base_color, [0.5; 3]);
}

/// The same graph, and so the same picture.
#[test]
fn a_whole_film_is_the_thin_film_of_blender() {
    let core = json!({ "metallicFactor": 0.25, "roughnessFactor": 0.5 });
    let with = |extension: &str, of: Value| {
        material(json!({ "pbrMetallicRoughness": core, "extensions": { extension: of } })).graph
    };
    let khronos = with(
        "KHR_materials_iridescence",
        json!({ "iridescenceFactor": 1.0, "iridescenceIor": 1.75, "iridescenceThicknessMaximum": 550.0 }),
    );
    let blender = with(
        "SUNDOG_material",
        json!({ "thin_film": { "thickness": 550.0, "ior": 1.75 } }),
    );
    assert_eq!(khronos, blender);
    let usual = with(
        "KHR_materials_iridescence",
        json!({ "iridescenceFactor": 1.0 }),
    );
    let of = shader(&usual);
    assert_eq!(
        most(&usual, of, principled::THIN_FILM_THICKNESS),
        [400.0; 3]
    );
    assert_eq!(most(&usual, of, principled::THIN_FILM_IOR), [1.3; 3]);
    let none = with(
        "KHR_materials_iridescence",
        json!({ "iridescenceIor": 2.0 }),
    );
    assert_eq!(
        none,
        material(json!({ "pbrMetallicRoughness": core })).graph
    );
}

#[test]
fn a_film_on_a_share_of_the_surface_is_a_mix_that_emits_once() {
    let of = material(json!({
        "emissiveFactor": [0.5, 0.25, 0.0],
        "extensions": { "KHR_materials_iridescence": { "iridescenceFactor": 0.25 } }
    }));
    assert_eq!(of.summary().emission.to_array(), [0.5, 0.25, 0.0]);
    let graph = &of.graph;
    let sum = shader(graph);
    assert_eq!(sum.kind, NodeKind::AddShader);
    let linked = |of: &Node, socket: usize| graph.node(of.inputs[socket].link().unwrap()).clone();
    assert_eq!(linked(sum, add_shader::B).kind, NodeKind::Emission);
    let mix = linked(sum, add_shader::A);
    assert_eq!(mix.inputs[mix_shader::FACTOR], Input::float(0.25));
    let (plain, filmed) = (linked(&mix, mix_shader::A), linked(&mix, mix_shader::B));
    assert_eq!(
        most(graph, &plain, principled::THIN_FILM_THICKNESS),
        [0.0; 3]
    );
    assert_eq!(
        most(graph, &filmed, principled::THIN_FILM_THICKNESS),
        [400.0; 3]
    );
    for shader in [&plain, &filmed] {
        assert_eq!(most(graph, shader, principled::EMISSION_STRENGTH), [0.0; 3]);
    }
    // Without emission there is no sum.
    let dark = material(json!({
        "extensions": { "KHR_materials_iridescence": { "iridescenceFactor": 0.25 } } }));
    assert_eq!(shader(&dark.graph).kind, NodeKind::MixShader);
}

#[test]
fn films_have_images_for_their_share_and_their_thickness() {
    let (mut file, share) = textured([128, 0, 0, 255]);
    let thickness = file.png_texture(image::RgbImage::new(2, 2).into());
    file.json["materials"] = json!([{ "extensions": { "KHR_materials_iridescence": {
        "iridescenceFactor": 1.0, "iridescenceTexture": { "index": share },
        "iridescenceThicknessMinimum": 200.0, "iridescenceThicknessMaximum": 600.0,
        "iridescenceThicknessTexture": { "index": thickness } } } }]);
    let graph = exact(&file).graph;
    let mix = shader(&graph);
    assert_eq!(images(&graph, mix, mix_shader::FACTOR), [0]);
    let filmed = graph.node(mix.inputs[mix_shader::B].link().unwrap());
    let socket = principled::THIN_FILM_THICKNESS;
    assert_eq!(images(&graph, filmed, socket), [1]);
    let results = graph.results(&mut Unit {
        vertex_alpha: false,
    });
    let range = graph.range_of(&results, filmed.inputs[socket], SocketKind::Float);
    assert_eq!(range.number(), (200.0, 600.0));
}

#[test]
fn diffuse_transmission_is_a_share_of_the_diffuse_base() {
    let (mut file, share) = textured([0, 0, 0, 128]);
    let color = file.png_texture(image::RgbImage::new(2, 2).into());
    let extension = json!({ "diffuseTransmissionFactor": 0.5,
        "diffuseTransmissionColorFactor": [1.0, 0.5, 0.25] });
    file.json["materials"] =
        json!([{ "extensions": { "KHR_materials_diffuse_transmission": extension } }]);
    let of = exact(&file);
    let shown = shader(&of.graph);
    assert_eq!(
        shown.inputs[principled::SUBSURFACE_WEIGHT],
        Input::float(0.5)
    );
    assert_eq!(
        shown.inputs[principled::SUBSURFACE_ANISOTROPY],
        Input::float(1.0)
    );
    assert_eq!(
        shown.inputs[principled::SUBSURFACE_COLOR],
        Input::Value([1.0, 0.5, 0.25])
    );
    assert!(of.summary().is_thin_subsurface);
    let extension =
        &mut file.json["materials"][0]["extensions"]["KHR_materials_diffuse_transmission"];
    extension["diffuseTransmissionTexture"] = json!({ "index": share });
    extension["diffuseTransmissionColorTexture"] = json!({ "index": color });
    let graph = exact(&file).graph;
    let shown = shader(&graph);
    assert_eq!(images(&graph, shown, principled::SUBSURFACE_WEIGHT), [0]);
    assert_eq!(images(&graph, shown, principled::SUBSURFACE_COLOR), [1]);
    // The share is the image's alpha.
    let weight = shown.inputs[principled::SUBSURFACE_WEIGHT].link().unwrap();
    let product = graph.node(weight);
    let alpha = product.inputs[node::math::B].link().unwrap();
    assert_eq!(alpha.output, node::ALPHA);
}

// --- variants ---

/// Two squares: one red, blue or green by variant, one always grey.
fn varied() -> Builder {
    let mut file = Builder::square();
    let color = |name: &str, r: u8, g: u8, b: u8| {
        json!({ "name": name,
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1] } })
    };
    file.json["materials"] = json!([
        color("red", 1, 0, 0),
        color("grey", 1, 1, 1),
        color("blue", 0, 0, 1),
        color("green", 0, 1, 0)
    ]);
    file.json["extensions"] = json!({ "KHR_materials_variants": {
        "variants": [{ "name": "summer" }, { "name": "winter" }, { "name": "autumn" }] } });
    let plain = file.json["meshes"][0]["primitives"][0].clone();
    let mut first = plain.clone();
    first["extensions"] = json!({ "KHR_materials_variants": { "mappings": [
        { "material": 3, "variants": [0] },
        { "material": 2, "variants": [1] }
    ] } });
    let mut second = plain;
    second["material"] = json!(1);
    file.json["meshes"][0]["primitives"] = json!([first, second]);
    file
}

fn shown(file: &Builder, variant: &str) -> Imported {
    let options = ImportOptions {
        variant: Some(variant.into()),
        ..ImportOptions::default()
    };
    file.load_with(&options).unwrap()
}

fn names(imported: &Imported) -> Vec<&str> {
    let materials = imported.scene.materials.iter();
    materials.map(|m| &*m.name).collect()
}

#[test]
fn a_variant_shows_its_materials_and_loads_no_others() {
    let file = varied();
    let usual = file.load();
    assert_eq!(usual.variants, ["summer", "winter", "autumn"]);
    assert_eq!(names(&usual), ["red", "grey"]);
    assert_eq!(codes(&usual), ["variants"]);
    for (variant, materials) in [
        ("summer", ["grey", "green"]),
        ("winter", ["grey", "blue"]),
        // What has nothing for a variant stays as it is.
        ("autumn", ["red", "grey"]),
    ] {
        let imported = shown(&file, variant);
        assert_eq!(names(&imported), materials);
        assert!(imported.diagnostics.is_empty(), "{:?}", codes(&imported));
        let of = |mesh: usize| imported.scene.meshes[mesh].material.unwrap().0 as usize;
        let both = [of(0), of(1)].map(|i| &*imported.scene.materials[i].name);
        assert_eq!(both[1], "grey");
        assert_ne!(both[0], "grey");
    }
}

#[test]
fn a_variant_that_is_not_there_is_an_error_that_names_those_that_are() {
    let ask = |file: &Builder| {
        let options = ImportOptions {
            variant: Some("spring".into()),
            ..ImportOptions::default()
        };
        file.load_with(&options).unwrap_err().to_string()
    };
    let error = ask(&varied());
    assert!(
        error.contains("variant \"spring\"") && error.contains("summer, winter, autumn"),
        "{error}"
    );
    let error = ask(&Builder::square());
    assert!(error.contains("the file has no variants"), "{error}");
}

#[test]
fn damaged_variants_are_one_clear_error() {
    let mut file = varied();
    file.json["extensions"]["KHR_materials_variants"]["variants"] = json!([3]);
    assert!(file.error().contains("its variants cannot be read"));
    let mut file = varied();
    let place = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings";
    *file.json.pointer_mut(place).unwrap() = json!([{ "material": 99, "variants": [1] }]);
    let options = ImportOptions {
        variant: Some("winter".into()),
        ..ImportOptions::default()
    };
    let error = file.load_with(&options).unwrap_err().to_string();
    assert!(
        error.contains("material 99, which does not exist"),
        "{error}"
    );
    *file.json.pointer_mut(place).unwrap() = json!("red");
    let error = file.load_with(&options).unwrap_err().to_string();
    assert!(
        error.contains("mesh 0") && error.contains("cannot be read"),
        "{error}"
    );
}

#[test]
fn the_effects_of_these_materials_are_called_for() {
    let cases = [
        (
            "KHR_materials_iridescence",
            json!({ "iridescenceFactor": 0.5 }),
            Effect::ThinFilm,
        ),
        (
            "KHR_materials_diffuse_transmission",
            json!({ "diffuseTransmissionFactor": 0.5 }),
            Effect::DiffuseTransmission,
        ),
    ];
    for (name, of, effect) in cases {
        let mut file = Builder::square();
        file.json["materials"] = json!([{ "extensions": { name: of } }]);
        let imported = file.load();
        let report = EffectReport::detect(&imported.scene);
        assert!(report.called_for.contains(effect), "{name}");
    }
}
