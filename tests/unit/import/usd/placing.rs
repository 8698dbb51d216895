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

/// A stage in centimetres: by the schema areas count them, while Blender writes the watts of metres into every stage.
#[test]
fn units_count_in_what_is_brought_to_an_area() {
    let centimetres = Frame {
        ours_from_stage: DAffine3::from_scale(DVec3::splat(0.01)),
        meters_per_unit: 0.01,
        z_up: true,
    };
    // As large as in metres.
    let matrix = DAffine3::from_scale(DVec3::splat(100.0));
    let strength = |lamp: &Lamp, frame: &Frame, matrix| match place(lamp, &matrix, None, frame) {
        Placed::Light(light) => match light.kind {
            LightKind::Point { intensity, .. } => f64::from(intensity),
            LightKind::Area { power, .. } => f64::from(power),
            _ => panic!("another light"),
        },
        _ => panic!("no light"),
    };
    let shapes = || {
        [
            Shape::Disk { radius: 0.5 },
            Shape::Rect {
                width: 2.0,
                height: 0.5,
            },
            Shape::Sphere {
                radius: 0.5,
                point: false,
            },
        ]
    };
    for (shape, (of_blender, share)) in shapes()
        .into_iter()
        .flat_map(|shape| [(true, 1.0), (false, 1e-4)].map(|expected| (shape.clone(), expected)))
    {
        let mut lamp = lamp(shape);
        (lamp.normalize, lamp.of_blender) = (true, of_blender);
        let metres = strength(&lamp, &frame(), DAffine3::IDENTITY);
        let found = strength(&lamp, &centimetres, matrix) / metres;
        assert!((found / share - 1.0).abs() < 1e-6, "{found}");
        lamp.normalize = false;
        let metres = strength(&lamp, &frame(), DAffine3::IDENTITY);
        let found = strength(&lamp, &centimetres, matrix);
        // The radiance is the same; the sphere's size is part of its intensity, the area light's of its matrix.
        assert!((found / metres - 1.0).abs() < 1e-6, "{found} {metres}");
    }
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
