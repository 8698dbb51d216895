use super::*;
use crate::sampler::{Dimension, Sequence};

const UP: Normals = Normals {
    geometric: Vec3::Z,
    curved: Vec3::Z,
    smooth: Vec3::Z,
    shading: Vec3::Z,
};

fn inputs() -> BelowInputs {
    BelowInputs {
        color: Vec3::new(0.8, 0.5, 0.2),
        radius: Vec3::new(0.01, 0.002, 0.001),
        alpha: 0.25,
        ior: 1.4,
        anisotropy: 0.0,
    }
}

fn what(method: WalkMethod) -> Subsurface {
    Subsurface {
        method,
        never_backward: false,
        diffuse_behind_diffuse: false,
    }
}

fn below(method: WalkMethod, inputs: &BelowInputs, wo: Vec3) -> Below {
    let (lobe, rest) = Below::new(Vec3::ONE, inputs, what(method), (&UP, Vec3::Z), wo);
    assert_eq!(rest, Vec3::ZERO);
    lobe.unwrap()
}

#[test]
fn channels_without_a_radius_scatter_at_the_surface() {
    let inputs = BelowInputs {
        radius: Vec3::new(0.0, 1.0, -1.0),
        ..inputs()
    };
    let weight = Vec3::new(0.5, 0.25, 0.125);
    let random = what(WalkMethod::RandomWalk);
    let (lobe, rest) = Below::new(weight, &inputs, random, (&UP, Vec3::Z), Vec3::Z);
    assert_eq!(lobe.unwrap().weight, Vec3::new(0.0, 0.25, 0.0));
    assert_eq!(rest, Vec3::new(0.5, 0.0, 0.125));
}

/// A smooth entry is refracted by Snell's law; a rough or diffuse one goes in, too, and no steeper than it may.
#[test]
fn light_enters_by_refraction() {
    let wo = Vec3::new(0.8, 0.0, 0.6);
    let smooth = BelowInputs {
        alpha: 0.0,
        ..inputs()
    };
    let lobe = below(WalkMethod::RandomWalk, &smooth, wo);
    let found = lobe.enter(Vec3::Z, wo, Vec2::splat(0.3), 0.5).unwrap();
    assert!((found.x + 0.8 / 1.4).abs() < 1e-6 && found.y.abs() < 1e-6 && found.z < 0.0);
    let n = 1 << 14;
    for method in [WalkMethod::RandomWalk, WalkMethod::Skin] {
        let lobe = below(method, &inputs(), wo);
        let (mut mean, mut count) = (Vec3::ZERO, 0);
        for s in 0..n {
            let u = Sequence::new(5)
                .sampler(s % 128, s / 128, 0)
                .triple(Dimension::Bsdf, 0);
            if let Some(direction) = lobe.enter(Vec3::Z, wo, u.truncate(), u.z) {
                assert!(direction.z < 0.0 && (direction.length() - 1.0).abs() < 1e-5);
                mean += direction;
                count += 1;
            }
        }
        mean /= count as f32;
        assert!(count as f32 > 0.98 * n as f32, "{method:?}: {count}");
        assert!(mean.x < -0.1 && mean.y.abs() < 0.02, "{method:?}: {mean}");
    }
}

#[test]
fn methods_have_their_radii() {
    let of = |method| below(method, &inputs(), Vec3::Z).radius;
    let walk = of(WalkMethod::RandomWalk);
    assert_eq!(walk, inputs().radius);
    let legacy = of(WalkMethod::Legacy) * (4.0 * std::f32::consts::PI);
    assert!((legacy - walk).abs().max_element() < 1e-8);
    assert_eq!(of(WalkMethod::Burley), of(WalkMethod::Legacy));
    // Darker skin absorbs more: of what is told as its diffusion length less is its mean free path. √3 where nothing comes back.
    let share = skin_share(Vec3::new(0.9, 0.4, 0.0), 1.4);
    assert!(share.x < share.y && share.y < share.z && (share.z - 3f32.sqrt()).abs() < 1e-6);
    for color in [0.05f32, 0.3, 0.7, 0.95] {
        let boundary = 2.0;
        let albedo = reduced_albedo(color, boundary);
        let s = (3.0 * (1.0 - albedo)).sqrt();
        let dipole = 0.5 * albedo * (1.0 + (-boundary * s).exp()) * (-s).exp();
        assert!((dipole - color).abs() < 0.02, "{color}: {dipole}");
    }
}

#[test]
fn anisotropies_are_as_far_as_each_version_goes() {
    let of = |what: Subsurface, anisotropy| {
        let inputs = BelowInputs {
            anisotropy,
            ..inputs()
        };
        let (lobe, _) = Below::new(Vec3::ONE, &inputs, what, (&UP, Vec3::Z), Vec3::Z);
        lobe.unwrap().anisotropy
    };
    let walk = what(WalkMethod::RandomWalk);
    assert_eq!([of(walk, 1.0), of(walk, -1.0)], [0.99, -0.99]);
    let legacy = what(WalkMethod::Legacy);
    assert_eq!([of(legacy, 1.0), of(legacy, -1.0)], [0.9, -0.99]);
    let old = Subsurface {
        never_backward: true,
        ..legacy
    };
    assert_eq!(of(old, -1.0), 0.0);
}
