//! A scene with some of everything, which can be moved, scaled, turned and mirrored as a whole.

use super::kit::{self, camera, constant_environment, diffuse, place, quad, sphere};
use crate::scene::{
    Aperture, AreaShape, Image, ImageId, Light, LightKind, MetallicRoughness, NormalTexture,
    Projection, Scene, Texture, TextureFilter, UvTransform,
};
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// The transform of a camera at a place that looks at another, Y up.
pub fn looking(eye: DVec3, at: DVec3) -> DAffine3 {
    let z = (eye - at).normalize();
    let x = DVec3::Y.cross(z).normalize();
    DAffine3 {
        matrix3: DMat3::from_cols(x, z.cross(x), z),
        translation: eye,
    }
}

/// What lights it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lit {
    /// A lamp of each kind, an emissive mesh, the sun and the sky; surfaces of all kinds, a lens.
    ByAll,
    /// A point and the sun without an angle, sharp reflections, a pinhole: with no diffuse bounces nothing in the
    /// picture depends on how directions are drawn about a normal, which is not the same after a turn.
    Sharply,
}

/// A change of place that keeps shapes: scaled, then turned or mirrored, then moved.
#[derive(Clone, Copy, Debug)]
pub struct Similarity {
    /// Of all lengths.
    pub scale: f64,
    /// Orthogonal.
    pub turn: DMat3,
    /// Added last.
    pub shift: DVec3,
}

impl Similarity {
    /// Leaves all where it is.
    pub const NONE: Self = Self {
        scale: 1.0,
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
    };

    fn matrix(&self) -> DAffine3 {
        DAffine3 {
            matrix3: self.turn * self.scale,
            translation: self.shift,
        }
    }

    /// The scene in its new place. Lights are so much stronger that what they shine on is as bright as before.
    pub fn of(&self, scene: &Scene) -> Scene {
        let (mut scene, by) = (scene.clone(), self.matrix());
        let (s, strength) = (self.scale, (self.scale * self.scale) as f32);
        for instance in &mut scene.instances {
            instance.world_from_object = by * instance.world_from_object;
        }
        for light in &mut scene.lights {
            light.world_from_light = by * light.world_from_light;
            match &mut light.kind {
                LightKind::Point {
                    intensity, radius, ..
                }
                | LightKind::Spot {
                    intensity, radius, ..
                } => {
                    *intensity *= strength;
                    *radius = (f64::from(*radius) * s) as f32;
                }
                // Its size is scaled by its transform.
                LightKind::Area { power, .. } => *power *= strength,
                LightKind::Sun { .. } => {}
            }
        }
        for camera in &mut scene.cameras {
            camera.world_from_camera = by * camera.world_from_camera;
            camera.clip_near *= s;
            camera.clip_far *= s;
            if let Projection::Orthographic {
                half_width,
                half_height,
            } = &mut camera.projection
            {
                (*half_width, *half_height) = (*half_width * s, *half_height * s);
            }
            if let Some(aperture) = &mut camera.aperture {
                aperture.radius *= s;
                aperture.focus_distance *= s;
            }
        }
        scene
    }
}

fn texture(image: u32) -> Texture {
    Texture {
        image: ImageId(image),
        uv_set: 0,
        transform: UvTransform::default(),
        sampler: crate::scene::Sampler {
            filter: TextureFilter::Linear,
            ..Default::default()
        },
    }
}

fn image(name: &str, pixel: impl Fn(u32, u32) -> [u8; 3]) -> Image {
    let pixels = (0..64).flat_map(|i| pixel(i % 8, i / 8));
    Image {
        name: name.into(),
        width: 8,
        height: 8,
        channels: 3,
        pixels: pixels.collect::<Vec<u8>>().into(),
    }
}

/// A light at a place that looks at another.
pub fn light(kind: LightKind, at: DVec3, toward: DVec3) -> Light {
    let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, (toward - at).normalize());
    Light {
        color: [1.0, 0.9, 0.8],
        ..kit::light("light", kind, DAffine3::from_rotation_translation(turn, at))
    }
}

fn lights(lit: Lit) -> Vec<Light> {
    let soft = if lit == Lit::ByAll { 1.0 } else { 0.0 };
    let (middle, soft_falloff) = (DVec3::new(0.0, 0.3, 0.0), false);
    let point = LightKind::Point {
        intensity: 3.0,
        radius: 0.05 * soft,
        soft_falloff,
    };
    let sun = LightKind::Sun {
        irradiance: 1.0,
        angle: 0.02 * soft,
    };
    let mut lights = vec![
        light(point, DVec3::new(1.3, 2.1, 1.7), middle),
        light(sun, DVec3::new(-2.0, 4.0, 3.0), middle),
    ];
    if lit == Lit::ByAll {
        let spot = LightKind::Spot {
            intensity: 6.0,
            radius: 0.03,
            soft_falloff,
            half_angle: 0.4,
            blend: 0.5,
        };
        let area = LightKind::Area {
            shape: AreaShape::Rectangle,
            size: [0.7, 0.4],
            power: 8.0,
            normalize: true,
            spread: std::f32::consts::PI,
        };
        lights.push(light(spot, DVec3::new(-1.6, 1.9, 1.1), middle));
        lights.push(light(area, DVec3::new(0.4, 2.3, -0.6), middle));
    }
    lights
}

/// Three copies of a mesh, of which one is squeezed and one is mirrored.
fn copies() -> [DAffine3; 3] {
    let at = |x: f64, y: f64, z: f64, scale: DVec3, angle: f64| {
        DAffine3::from_scale_rotation_translation(
            scale,
            DQuat::from_rotation_y(angle),
            DVec3::new(x, y, z),
        )
    };
    [
        at(-1.1, 0.25, 0.4, DVec3::splat(0.25), 0.3),
        at(-0.4, 0.2, 0.9, DVec3::new(0.3, 0.2, 0.15), 0.8),
        at(0.5, 0.22, 1.0, DVec3::new(-0.2, 0.22, 0.2), -0.4),
    ]
}

/// The scene.
pub fn still_life(lit: Lit) -> Scene {
    let mut scene = Scene {
        lights: lights(lit),
        images: vec![
            image("checker", |x, y| {
                [if (x + y) % 2 == 0 { 90 } else { 220 }; 3]
            }),
            // Waves along one axis and a tilt along the other: not the same when mirrored.
            image("waves", |x, _| {
                if x % 4 < 2 {
                    [168, 148, 240]
                } else {
                    [98, 148, 240]
                }
            }),
        ],
        ..Scene::default()
    };
    let rough = if lit == Lit::ByAll { 0.3 } else { 0.0 };
    let floor = MetallicRoughness {
        base_color_texture: Some(texture(0)),
        normal_texture: Some(NormalTexture {
            texture: texture(1),
            scale: 1.0,
        }),
        ..diffuse([0.8, 0.8, 0.8])
    };
    let metal = MetallicRoughness {
        base_color: [0.9, 0.7, 0.4],
        metallic: 1.0,
        roughness: rough,
        ..MetallicRoughness::default()
    };
    let glass = kit::glass(0.0, 1.5);
    let here = &[DAffine3::IDENTITY];
    let ground = quad([-3.0, 0.0, 2.5], [6.0, 0.0, 0.0], [0.0, 0.0, -5.0]);
    let wall = quad([-3.0, 0.0, -1.5], [6.0, 0.0, 0.0], [0.0, 3.0, 0.0]);
    place(&mut scene, ground, floor, here);
    place(&mut scene, wall, diffuse([0.4, 0.6, 0.7]), here);
    let ball = |radius: f64, x: f64, y: f64, z: f64| {
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(radius),
            DQuat::from_rotation_x(0.7),
            DVec3::new(x, y, z),
        )
    };
    place(
        &mut scene,
        sphere(24, 0.1, true),
        metal,
        &[ball(0.45, 0.7, 0.55, -0.3)],
    );
    place(
        &mut scene,
        sphere(24, 0.0, true),
        glass,
        &[ball(0.35, -0.35, 0.36, 0.1)],
    );
    place(
        &mut scene,
        sphere(12, 0.1, false),
        diffuse([0.7, 0.3, 0.2]),
        &copies(),
    );
    if lit == Lit::ByAll {
        let panel = quad([-1.9, 0.9, -1.2], [0.6, 0.0, 0.2], [0.0, 0.5, 0.1]);
        let shining = MetallicRoughness {
            emission: [4.0, 5.0, 6.0],
            ..diffuse([0.2; 3])
        };
        place(&mut scene, panel, shining, here);
        scene.environment = constant_environment(0.2);
    }
    let eye = DVec3::new(0.3, 1.1, 3.4);
    let mut view = camera(eye, 0.75);
    view.world_from_camera = looking(eye, DVec3::new(0.0, 0.4, 0.0));
    (view.clip_near, view.clip_far) = (0.1, 50.0);
    view.aperture = (lit == Lit::ByAll).then_some(Aperture {
        radius: 0.02,
        blades: 5,
        rotation: 0.2,
        ratio: 1.2,
        focus_distance: 3.3,
    });
    scene.cameras.push(view);
    scene
}
