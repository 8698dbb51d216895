use super::*;
use crate::import::usd::lights::Dome;

fn frame() -> Frame {
    Frame {
        ours_from_stage: DAffine3::IDENTITY,
        meters_per_unit: 1.0,
        z_up: false,
    }
}

fn lamp(shape: Shape) -> Lamp {
    Lamp {
        name: "lamp".into(),
        path: "/lamp".into(),
        shape,
        color: [1.0; 3],
        strength: 6.0,
        normalize: false,
        shaping: Shaping::default(),
        ies: None,
        image: None,
        linked: Default::default(),
        shadows: true,
        of_blender: false,
    }
}

fn kind(lamp: &Lamp, matrix: DAffine3) -> LightKind {
    match place(lamp, &matrix, None, &frame()) {
        Placed::Light(light) => light.kind,
        _ => panic!("no light"),
    }
}

/// UsdLux: the intensity is radiance, and that of a normalized light is divided by its area in the world.
#[test]
fn spheres_and_rectangles_shine_as_the_schema_says() {
    let mut sphere = lamp(Shape::Sphere {
        radius: 0.5,
        point: false,
    });
    let twice = DAffine3::from_scale(DVec3::splat(2.0));
    let LightKind::Point {
        intensity, radius, ..
    } = kind(&sphere, twice)
    else {
        panic!()
    };
    assert!((f64::from(intensity) - 6.0 * PI).abs() < 1e-5);
    assert_eq!(radius, 1.0);
    sphere.normalize = true;
    let LightKind::Point { intensity, .. } = kind(&sphere, twice) else {
        panic!()
    };
    assert!((intensity - 1.5).abs() < 1e-6);
    let mut rect = lamp(Shape::Rect {
        width: 2.0,
        height: 0.5,
    });
    rect.normalize = true;
    let wide = DAffine3::from_scale(DVec3::new(3.0, 1.0, 1.0));
    let LightKind::Area {
        power, normalize, ..
    } = kind(&rect, wide)
    else {
        panic!()
    };
    assert!(!normalize && (f64::from(power) - PI * 2.0).abs() < 1e-5);
}

#[test]
fn suns_have_the_projected_angle_of_their_disc() {
    let angle = 0.2;
    let sun = lamp(Shape::Distant { angle });
    let LightKind::Sun { irradiance, .. } = kind(&sun, DAffine3::IDENTITY) else {
        panic!()
    };
    let sin = (0.1f64).sin();
    assert!((f64::from(irradiance) - 6.0 * PI * sin * sin).abs() < 1e-6);
    // Blender writes a quarter of the strength and half of the angle.
    let blenders = Lamp {
        of_blender: true,
        ..sun
    };
    let LightKind::Sun { irradiance, angle } = kind(&blenders, DAffine3::IDENTITY) else {
        panic!()
    };
    assert_eq!([irradiance, angle], [24.0, 0.4]);
}

/// Blender's: a dome turned by 90° about X and then by 90° about Z has its middle on +X.
#[test]
fn domes_stand_as_in_blender() {
    let dome = lamp(Shape::Dome(Dome::default()));
    let matrix =
        DAffine3::from_mat3(DMat3::from_rotation_z(0.5 * PI) * DMat3::from_rotation_x(0.5 * PI));
    let upright = Frame {
        z_up: true,
        ..frame()
    };
    let Placed::Dome { turn, .. } = place(&dome, &matrix, None, &upright) else {
        panic!()
    };
    assert!(
        (turn - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-12),
        "{turn}"
    );
}

#[test]
fn cylinders_become_meshes_of_the_same_radiance() {
    let mut tube = lamp(Shape::Cylinder {
        radius: 0.5,
        length: 2.0,
    });
    tube.normalize = true;
    let Placed::Mesh(mesh, radiance) = place(&tube, &DAffine3::IDENTITY, None, &frame()) else {
        panic!()
    };
    assert!(!mesh.triangles.is_empty());
    assert!((f64::from(radiance[0]) - 6.0 / (2.0 * PI)).abs() < 1e-5);
}
