//! A scene from a recipe. Whatever is missing has a default and whatever makes no sense is taken as it stands, so that
//! any part of a recipe may be left out.

use super::rng::Rng;
use glam::{DAffine3, DMat3, DVec3, EulerRot};
use serde_json::Value;
use sundog::film::{Pass, Passes};
use sundog::math::panorama::Panorama;
use sundog::render::{BounceLimits, LightSampling, RenderSettings};
use sundog::scene::graph::{AovOutput, SocketKind};
use sundog::scene::{
    AlphaMode, Aov, Aperture, AreaShape, Camera, Environment, Image, ImageAlpha, ImageId, Light,
    LightKind, Mesh, MeshStep, MetallicRoughness, NormalTexture, Portal, Projection, RayKind,
    Sampler, Scene, SphericalStereo, Texture, TextureFilter, UvTransform, Visibility, Wrap,
};
use sundog::selftest::kit::{camera as pinhole, place, quad, sphere};

/// A number, also one that JSON has only words for.
pub fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::String(word) => word.parse().ok(),
        _ => None,
    }
}

fn n(of: &Value, name: &str, default: f64) -> f64 {
    number(&of[name]).unwrap_or(default)
}

fn f(of: &Value, name: &str, default: f64) -> f32 {
    n(of, name, default) as f32
}

/// A number within bounds; the lower one for what is not a number, which `clamp` would let through.
fn within(of: &Value, name: &str, least: f64, most: f64) -> f64 {
    bounded(n(of, name, least), least, most)
}

fn bounded(number: f64, least: f64, most: f64) -> f64 {
    if number >= least {
        number.min(most)
    } else {
        least
    }
}

fn is(of: &Value, name: &str) -> bool {
    of[name].as_bool().unwrap_or(false)
}

fn text<'a>(of: &'a Value, name: &str) -> &'a str {
    of[name].as_str().unwrap_or_default()
}

fn list<'a>(of: &'a Value, name: &str) -> &'a [Value] {
    of[name].as_array().map_or(&[], Vec::as_slice)
}

fn three(of: &Value, name: &str, default: f64) -> [f64; 3] {
    let at = |i: usize| list(of, name).get(i).and_then(number).unwrap_or(default);
    [at(0), at(1), at(2)]
}

fn color(of: &Value, name: &str) -> [f32; 3] {
    three(of, name, 1.0).map(|c| c as f32)
}

/// The scene of a recipe.
pub fn scene(recipe: &Value) -> Scene {
    let scale = n(recipe, "scale", 1.0);
    let world = DAffine3 {
        matrix3: DMat3::from_diagonal(DVec3::splat(scale)),
        translation: DVec3::from(three(recipe, "center", 0.0)),
    };
    let mut scene = Scene::default();
    for thing in list(recipe, "things") {
        add(&mut scene, thing, &world);
    }
    for of in list(recipe, "lights") {
        scene.lights.push(light(of, scale, &world));
    }
    if is(recipe, "furnace") {
        scene.environment = sundog::selftest::kit::constant_environment(1.0);
    } else if recipe["environment"].is_object() {
        scene.environment = Some(environment(&mut scene, &recipe["environment"]));
    }
    let mut camera = camera(&recipe["camera"], scale, &world);
    if let Some(kind) = recipe["panorama"].as_u64() {
        camera.projection = panorama(kind);
        camera.stereo = number(&recipe["eye"]).map(|offset| SphericalStereo {
            offset: offset * scale,
            convergence: 2.0 * scale,
            pole_merge: Some([0.5, 1.0]),
        });
    }
    scene.cameras.push(camera);
    scene.shutter.still = is(recipe, "still");
    if let Some(seed) = recipe["links"].as_u64() {
        link(&mut scene, seed);
    }
    if let Some(seed) = recipe["portals"].as_u64() {
        open(&mut scene, seed, &world);
    }
    if let Some(seed) = recipe["aovs"].as_u64() {
        tell(&mut scene, seed);
    }
    if let Some(seed) = recipe["catchers"].as_u64() {
        let mut rng = Rng::new(seed);
        for instance in &mut scene.instances {
            instance.info.links.shadow_catcher = Some(rng.chance(0.5));
        }
        for light in &mut scene.lights {
            light.links.shadow_catcher = Some(rng.chance(0.7));
        }
    }
    scene
}

/// Openings about the middle, of any size and shape, some of them none.
fn open(scene: &mut Scene, seed: u64, world: &DAffine3) {
    let mut rng = Rng::new(seed);
    for number in 0..1 + rng.below(3) {
        let mut around = |size: f64| size * (2.0 * rng.unit() - 1.0);
        let at = DVec3::new(around(2.0), around(2.0), around(2.0));
        let turn = DAffine3::from_rotation_x(around(3.0)) * DAffine3::from_rotation_y(around(3.0));
        let place = *world * DAffine3::from_translation(at) * turn;
        scene.portals.push(Portal {
            name: format!("portal {number}"),
            shape: rng.pick(&[AreaShape::Rectangle, AreaShape::Ellipse]),
            size: [(); 2].map(|()| rng.pick(&[0.0, 1e-6, 0.5, 2.0, 1e6])),
            world_from_portal: place,
        });
    }
}

/// Two passes of the scene's own, a colour and a number, which materials tell what some of their sockets have.
fn tell(scene: &mut Scene, seed: u64) {
    let mut rng = Rng::new(seed);
    for (name, is_color) in [("mine", true), ("other", false)] {
        scene.aovs.push(Aov {
            name: name.into(),
            is_color,
        });
    }
    for material in &mut scene.materials {
        let graph = &mut material.graph;
        let inputs = graph.nodes.iter().flat_map(|node| &node.inputs);
        let links = inputs.filter_map(|input| input.link());
        let colors = links.filter(|link| graph.gives(*link).0 == SocketKind::Color);
        let colors: Vec<_> = colors.collect();
        if !colors.is_empty() && rng.chance(0.8) {
            // The color has four floats, and the number the one after them.
            for (first, is_color) in [(0, true), (4, false)] {
                let value = Some(rng.pick(&colors));
                graph.aovs.push(AovOutput {
                    first,
                    is_color,
                    value,
                });
            }
        }
    }
}

/// Puts things into sets, and links what may shine to some of them.
fn link(scene: &mut Scene, seed: u64) {
    let mut rng = Rng::new(seed);
    let sets = [u64::MAX, u64::MAX, 0, 1, 2, 5];
    let things = scene.instances.iter_mut().map(|i| &mut i.info.links);
    for links in things.chain(scene.lights.iter_mut().map(|light| &mut light.links)) {
        (links.lit_sets, links.shadow_sets) = (rng.pick(&sets), rng.pick(&sets));
        (links.receiver_set, links.blocker_set) = (rng.below(3) as u8, rng.below(3) as u8);
    }
}

/// One of the kinds of panorama.
fn panorama(kind: u64) -> Projection {
    let fov = 3.0;
    let kind = match kind {
        0 => Panorama::FisheyeEquidistant { fov },
        1 => Panorama::FisheyeEquisolid {
            lens: 10.5,
            fov,
            sensor: glam::Vec2::new(36.0, 27.0),
        },
        2 => Panorama::FisheyePolynomial {
            coefficients: [0.0, -0.08, 0.0, 1e-4, 0.0],
            fov,
            sensor: glam::Vec2::new(36.0, 27.0),
        },
        3 => Panorama::MirrorBall,
        4 => Panorama::CubeFace,
        _ => Panorama::CentralCylindrical {
            longitude: [-1.0, 2.0],
            height: [-1.0, 1.0],
        },
    };
    let shift = [0.1, 0.0];
    Projection::Panorama { kind, shift }
}

fn local(of: &Value) -> DAffine3 {
    let [x, y, z] = three(of, "turn", 0.0).map(f64::to_radians);
    DAffine3 {
        matrix3: DMat3::from_euler(EulerRot::XYZ, x, y, z)
            * DMat3::from_diagonal(DVec3::from(three(of, "scale", 1.0))),
        translation: DVec3::from(three(of, "at", 0.0)),
    }
}

fn visibility(of: &Value) -> Visibility {
    let mut seen = Visibility::ALL;
    if let Some(bits) = of["visibility"].as_f64() {
        for (kind, _) in RayKind::ALL {
            if bits as u32 & kind.bit() == 0 {
                seen = seen.without(kind);
            }
        }
    }
    seen
}

fn mesh(of: &Value) -> Mesh {
    let (unit, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let mut mesh = match text(of, "shape") {
        "sphere" => {
            let rings = within(of, "rings", 2.0, 64.0) as u32;
            return sphere(rings, f(of, "bumps", 0.0), is(of, "smooth"));
        }
        "sliver" => quad([-1.0, 0.0, 0.0], [2.0, 1e-8, 0.0], [1.0, 2e-8, 0.0]),
        "twins" => quad([-0.5, -0.5, 0.0], unit, up),
        "sheets" => {
            let mut mesh = quad([-0.5, -0.5, 0.0], unit, up);
            for i in 1..4 {
                let other = quad([-0.5, -0.5, 1e-6 * i as f32], unit, up);
                join(&mut mesh, &other);
            }
            mesh
        }
        "box" => {
            let (l, h) = (-0.5, 0.5);
            let mut mesh = quad([l, l, h], unit, up);
            for other in [
                quad([h, l, l], [-1.0, 0.0, 0.0], up),
                quad([l, l, l], [0.0, 0.0, 1.0], up),
                quad([h, l, h], [0.0, 0.0, -1.0], up),
                quad([l, h, h], unit, [0.0, 0.0, -1.0]),
                quad([l, l, l], unit, [0.0, 0.0, 1.0]),
            ] {
                join(&mut mesh, &other);
            }
            mesh
        }
        _ => quad([-1.5, -1.5, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]),
    };
    if text(of, "shape") == "twins" {
        mesh.triangles.extend(mesh.triangles.clone());
    }
    mesh
}

fn join(mesh: &mut Mesh, other: &Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&other.positions);
    for (uvs, more) in mesh.uvs.iter_mut().zip(&other.uvs) {
        uvs.extend(more);
    }
    let moved = other.triangles.iter().map(|t| t.map(|i| i + first));
    mesh.triangles.extend(moved);
}

fn add(scene: &mut Scene, thing: &Value, world: &DAffine3) {
    let mut mesh = mesh(thing);
    if let Some(seed) = thing["colors"].as_u64() {
        let mut rng = Rng::new(seed);
        let colors = mesh
            .positions
            .iter()
            .map(|_| [(); 4].map(|()| rng.unit() as f32));
        mesh.colors = Some(colors.collect());
    }
    if let Some(seed) = thing["deformation"].as_u64() {
        mesh.motion = deformation(&mesh, seed);
    }
    let material = material(scene, &thing["material"]);
    let mut transforms: Vec<DAffine3> = list(thing, "places")
        .iter()
        .map(|of| *world * local(of))
        .collect();
    if transforms.is_empty() {
        transforms.push(*world);
    }
    let first = scene.instances.len();
    place(scene, mesh, material, &transforms);
    for instance in &mut scene.instances[first..] {
        instance.visibility = visibility(thing);
        instance.holdout = is(thing, "holdout");
        if let Some(seed) = thing["motion"].as_u64() {
            let still = instance.world_from_object;
            instance.motion = motion(seed).iter().map(|step| still * *step).collect();
        }
    }
}

/// Between two and five places about where a thing is, turned and stretched.
fn motion(seed: u64) -> Vec<DAffine3> {
    let mut rng = Rng::new(seed);
    let steps = 2 + rng.below(4);
    let mut around = |size: f64| size * (2.0 * rng.unit() - 1.0);
    let step = |_| {
        let mut three = |size| DVec3::new(around(size), around(size), around(size));
        let (turn, at, scale) = (three(2.0), three(0.5), three(0.5));
        DAffine3::from_scale_rotation_translation(
            DVec3::ONE + scale,
            glam::DQuat::from_scaled_axis(turn),
            at,
        )
    };
    (0..steps).map(step).collect()
}

/// A mesh at as many steps, stretched and skewed.
fn deformation(mesh: &Mesh, seed: u64) -> Vec<MeshStep> {
    let step = |place: &DAffine3| MeshStep {
        positions: mesh
            .positions
            .iter()
            .map(|p| place.transform_point3(glam::Vec3::from(*p).as_dvec3()))
            .map(|p| p.as_vec3().to_array())
            .collect(),
        normals: mesh.normals.clone(),
    };
    motion(seed).iter().map(step).collect()
}

fn material(scene: &mut Scene, of: &Value) -> MetallicRoughness {
    let texture = |scene: &mut Scene, name: &str| {
        let seed = of[format!("{name}_texture")].as_u64()?;
        Some(texture(scene, seed))
    };
    MetallicRoughness {
        name: format!("material {}", scene.materials.len()),
        base_color: color(of, "color"),
        base_color_texture: texture(scene, "color"),
        alpha: f(of, "alpha", 1.0),
        alpha_mode: match text(of, "alpha_mode") {
            "blend" => AlphaMode::Blend,
            "mask" => AlphaMode::Mask { cutoff: 0.5 },
            _ => AlphaMode::Opaque,
        },
        metallic: f(of, "metallic", 0.0),
        roughness: f(of, "roughness", 0.5),
        glossiness: None,
        metallic_roughness_texture: texture(scene, "metallic_roughness"),
        normal_texture: texture(scene, "normal").map(|texture| NormalTexture {
            texture,
            scale: f(of, "normal_scale", 1.0),
        }),
        emission: [f(of, "emission", 0.0); 3],
        emission_texture: None,
        ior: f(of, "ior", 1.5),
        rules: Default::default(),
        dispersion: f(of, "dispersion", 0.0),
        specular: f(of, "specular", 1.0),
        specular_texture: texture(scene, "specular"),
        specular_color: color(of, "specular_color"),
        specular_color_texture: texture(scene, "specular_color"),
        transmission: f(of, "transmission", 0.0),
        transmission_texture: texture(scene, "transmission"),
        thin_walled: is(of, "thin"),
        glossy: None,
        simple: None,
        transparent_color: [1.0; 3],
        diffuse_roughness: 0.0,
        edge_tint: false,
        anisotropy: None,
        coat: None,
        sheen: None,
        thin_film: None,
        iridescence: None,
        diffuse_transmission: None,
        double_sided: is(of, "double_sided"),
        unlit: is(of, "unlit"),
        medium: None,
        priority: None,
    }
}

/// An image of a few random texels, and how it lies.
fn texture(scene: &mut Scene, seed: u64) -> Texture {
    let mut rng = Rng::new(seed);
    let (width, height, channels) = (
        rng.pick(&[1, 2, 5]),
        rng.pick(&[1, 3, 4]),
        1 + rng.below(4) as u32,
    );
    let count = (width * height * channels) as usize;
    let extreme = rng.chance(0.5);
    let mut value = || {
        if extreme {
            rng.pick(&[0.0, 1.0])
        } else {
            rng.unit()
        }
    };
    let wide = seed.is_multiple_of(3);
    let pixels = if wide {
        (0..count)
            .map(|_| (value() * 65_535.0) as u16)
            .collect::<Vec<u16>>()
            .into()
    } else {
        (0..count)
            .map(|_| (value() * 255.0) as u8)
            .collect::<Vec<u8>>()
            .into()
    };
    scene.images.push(Image {
        name: format!("image {}", scene.images.len()),
        width,
        height,
        channels,
        pixels,
    });
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    Texture {
        image: ImageId(scene.images.len() as u32 - 1),
        uv_set: u32::from(rng.chance(0.1)),
        transform: UvTransform {
            offset: [rng.between(-2.0, 2.0) as f32, 0.0],
            rotation: rng.pick(&[0.0, 1.0, 1e6]),
            scale: rng.pick(&[[1.0, 1.0], [0.0, 0.0], [1e9, -1.0]]),
        },
        sampler: Sampler {
            wrap_u: rng.pick(&wraps),
            wrap_v: rng.pick(&wraps),
            filter: rng.pick(&[TextureFilter::Linear, TextureFilter::Nearest]),
            alpha: if rng.chance(0.2) {
                ImageAlpha::WEIGHTED
            } else {
                ImageAlpha::ChannelPacked
            },
        },
    }
}

fn light(of: &Value, scale: f64, world: &DAffine3) -> Light {
    let strength = f(of, "strength", 1.0);
    // So that the picture does not depend on the scale.
    let power = (n(of, "strength", 1.0) * scale * scale) as f32;
    let radius = (n(of, "radius", 0.0) * scale) as f32;
    let angle = f(of, "angle", 10.0).to_radians();
    let soft_falloff = is(of, "soft");
    let kind = match text(of, "kind") {
        "spot" => LightKind::Spot {
            intensity: power,
            radius,
            soft_falloff,
            half_angle: angle,
            blend: f(of, "blend", 0.0),
        },
        "sun" => LightKind::Sun {
            irradiance: strength,
            angle,
        },
        "area" => LightKind::Area {
            shape: if is(of, "ellipse") {
                AreaShape::Ellipse
            } else {
                AreaShape::Rectangle
            },
            size: [0, 1].map(|i| {
                let size = list(of, "size").get(i).and_then(number);
                size.unwrap_or(1.0) as f32
            }),
            power: if is(of, "normalize") { power } else { strength },
            normalize: is(of, "normalize"),
            spread: f(of, "spread", 180.0).to_radians(),
        },
        _ => LightKind::Point {
            intensity: power,
            radius,
            soft_falloff,
        },
    };
    Light {
        name: "light".into(),
        color: color(of, "color"),
        kind,
        world_from_light: *world * local(of),
        visibility: visibility(of),
        max_bounces: n(of, "max_bounces", f64::from(Light::MAX_BOUNCES)) as u32,
        is_hit: n(of, "is_hit", 1.0) != 0.0,
        links: Default::default(),
        graph: None,
    }
}

fn environment(scene: &mut Scene, of: &Value) -> Environment {
    let image = of["image"].as_u64().map(|seed| {
        let mut rng = Rng::new(seed);
        let size = |i: usize| {
            let size = list(of, "size").get(i).and_then(number).unwrap_or(4.0);
            bounded(size, 1.0, 64.0) as u32
        };
        let (width, height) = (size(0), size(1));
        let count = (3 * width * height) as usize;
        let mut texels: Vec<f32> = (0..count).map(|_| rng.unit() as f32).collect();
        let at = rng.below(count / 3) * 3;
        texels[at..at + 3].fill(within(of, "spike", 0.0, 1e9) as f32);
        scene.images.push(Image {
            name: "world".into(),
            width,
            height,
            channels: 3,
            pixels: texels.into(),
        });
        ImageId(scene.images.len() as u32 - 1)
    });
    Environment {
        image,
        radiance: [f(of, "strength", 1.0); 3],
        rotation: Environment::turned_about_up(f(of, "rotation", 0.3)),
        visibility: visibility(of),
        links: Default::default(),
        graph: None,
    }
}

fn camera(of: &Value, scale: f64, world: &DAffine3) -> Camera {
    let fov = n(of, "fov", 50.0).to_radians();
    let place = DVec3::from(three(of, "at", 0.0));
    let projection = match text(of, "kind") {
        "orthographic" => Projection::Orthographic {
            half_width: 2.0 * scale,
            half_height: 1.5 * scale,
        },
        "panorama" => Projection::Equirectangular {
            longitude: [-std::f64::consts::PI, std::f64::consts::PI],
            latitude: [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2],
        },
        _ => Projection::Perspective {
            vertical_fov: fov,
            aspect: None,
        },
    };
    Camera {
        projection,
        clip_near: n(of, "near", 0.0) * scale,
        clip_far: n(of, "far", f64::INFINITY) * scale,
        aperture: number(&of["aperture"]).map(|radius| Aperture {
            radius: radius * scale,
            blades: n(of, "blades", 0.0) as u32,
            rotation: 0.1,
            ratio: 1.0,
            focus_distance: n(of, "focus", 1.0) * scale,
        }),
        ..pinhole(world.transform_point3(place), fov)
    }
}

/// The settings of a recipe.
pub fn settings(recipe: &Value) -> RenderSettings {
    let of = &recipe["settings"];
    let limit = |name: &str| {
        let limit = n(of, name, -1.0);
        (limit >= 0.0).then_some(limit as u32)
    };
    let positive = |name: &str| {
        let value = f(of, name, 0.0);
        if value.is_finite() {
            value.max(0.0)
        } else {
            0.0
        }
    };
    RenderSettings {
        width: 16,
        height: 12,
        samples: within(recipe, "samples", 1.0, 64.0) as u32,
        seed: n(recipe, "seed", 0.0) as u32,
        bounces: n(recipe, "bounces", 4.0).clamp(0.0, 100.0) as u32,
        bounce_limits: BounceLimits {
            glossy: limit("glossy_limit"),
            transparent: limit("transparent_limit"),
            ..BounceLimits::default()
        },
        clamp_direct: positive("clamp_direct"),
        clamp_indirect: positive("clamp_indirect"),
        filter_glossy: positive("filter_glossy"),
        light_sampling: match text(of, "light_sampling") {
            "nee" => LightSampling::Nee,
            "bsdf" => LightSampling::Bsdf,
            _ => LightSampling::Mis,
        },
        light_samples: within(of, "light_samples", 1.0, 8.0) as u32,
        roulette: Some(n(of, "roulette", 2.0) as u32).filter(|&bounce| bounce > 0),
        cull_backfaces: is(of, "cull"),
        transparent_film: is(of, "transparent_film"),
        transparent_glass: is(of, "transparent_glass").then_some(0.3),
        center_passes: is(recipe, "centre_passes"),
        passes: match recipe["aovs"].is_u64() {
            true => Passes::default().with(Pass::Aov),
            false => Passes::default(),
        },
        ..RenderSettings::default()
    }
}
