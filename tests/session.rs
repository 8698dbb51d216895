//! Sessions: a scene that is edited gives the picture of one that was always so.

use glam::{DAffine3, DQuat, DVec3};
use sundog::render::{EditError, Silent};
use sundog::scene::{
    AlphaMode, Camera, Environment, Instance, Light, LightKind, Material, MaterialId, Medium, Mesh,
    MeshId, MetallicRoughness, Visibility,
};
use sundog::selftest::kit::{place, sphere};
use sundog::world::Stale;
use sundog::{Edit, Scene, Session, Settings};

/// A square of size 2 in the plane z = 0, of material 0.
fn square() -> Mesh {
    Mesh {
        name: "square".into(),
        positions: vec![
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(MaterialId(0)),
        ..Mesh::default()
    }
}

fn matte(color: [f32; 3]) -> MetallicRoughness {
    MetallicRoughness {
        name: "matte".into(),
        base_color: color,
        metallic: 0.0,
        roughness: 1.0,
        double_sided: true,
        ..MetallicRoughness::default()
    }
}

fn lamp(x: f64) -> Light {
    Light {
        name: "lamp".into(),
        world_from_light: DAffine3::from_translation(DVec3::new(x, 0.5, 2.0)),
        color: [1.0; 3],
        kind: LightKind::Point {
            intensity: 3.0,
            radius: 0.1,
            soft_falloff: false,
        },
        visibility: Visibility::ALL,
        max_bounces: 1024,
        is_hit: true,
        links: Default::default(),
        graph: None,
    }
}

fn instance(x: f64) -> Instance {
    Instance {
        motion: Vec::new(),
        name: "placed".into(),
        mesh: MeshId(0),
        world_from_object: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
        visibility: Visibility::ALL,
        holdout: false,
        info: Default::default(),
    }
}

fn camera(x: f64) -> Camera {
    Camera::perspective(DAffine3::from_translation(DVec3::new(x, 0.0, 4.0)), 0.9)
}

/// Two squares, a lamp, a dim sky.
fn scene() -> Scene {
    Scene {
        meshes: vec![square()],
        instances: vec![instance(-1.2), instance(1.2)],
        materials: vec![matte([0.8, 0.5, 0.2]).into()],
        lights: vec![lamp(0.0)],
        environment: Some(Environment::constant([0.1; 3])),
        cameras: vec![camera(0.0)],
        ..Scene::default()
    }
}

fn settings() -> Settings {
    Settings {
        width: 24,
        height: 16,
        samples: 8,
        threads: Some(1),
        ..Settings::default()
    }
}

fn rendered(session: &mut Session) -> Vec<f32> {
    session.render(&Silent).unwrap().picture.layers[0]
        .data
        .clone()
}

/// Every kind of edit, with the scene that was always so.
#[test]
fn an_edited_scene_has_the_bits_of_one_that_was_always_so() {
    let mesh = Mesh {
        triangles: vec![[0, 1, 2]],
        ..square()
    };
    let (light, material) = (lamp(1.0), Material::from(matte([0.1, 0.6, 0.9])));
    let (sky, place) = (
        Environment::constant([0.3, 0.2, 0.1]),
        instance(0.4).world_from_object,
    );
    let (with_mesh, with_light, with_material) = (
        Scene {
            meshes: vec![mesh.clone()],
            ..scene()
        },
        Scene {
            lights: vec![light.clone()],
            ..scene()
        },
        Scene {
            materials: vec![material.clone()],
            ..scene()
        },
    );
    let with_sky = Scene {
        environment: Some(sky.clone()),
        ..scene()
    };
    let with_place = Scene {
        instances: vec![instance(0.4), instance(1.2)],
        ..scene()
    };
    let glass = MetallicRoughness {
        transmission: 1.0,
        thin_walled: false,
        roughness: 0.3,
        ..matte([1.0; 3])
    };
    let glass = Material::from(glass);
    let with_glass = Scene {
        materials: vec![glass.clone()],
        ..scene()
    };
    let lights = Stale {
        lights: true,
        ..Stale::NONE
    };
    let surfaces = Stale {
        materials: true,
        ..lights
    };
    let places = Stale {
        geometry: true,
        ..lights
    };
    let cases = [
        (
            Edit::Mesh {
                number: 0,
                mesh: Box::new(mesh),
            },
            with_mesh,
            Stale::ALL,
        ),
        (
            Edit::Light {
                number: 0,
                light: Box::new(light),
            },
            with_light,
            lights,
        ),
        (
            Edit::Material {
                number: 0,
                material: Box::new(material),
            },
            with_material,
            surfaces,
        ),
        // Another set of effects is another world.
        (
            Edit::Material {
                number: 0,
                material: Box::new(glass),
            },
            with_glass,
            Stale::ALL,
        ),
        (Edit::Environment(Some(sky)), with_sky, lights),
        (
            Edit::Transform {
                instance: 0,
                world_from_object: place,
            },
            with_place,
            places,
        ),
    ];
    for (edit, edited, stale) in cases {
        let name = format!("{edit:?}");
        let mut session = Session::owning(scene(), settings());
        let before = rendered(&mut session);
        session.apply(edit).unwrap();
        assert_eq!(session.prepare().unwrap(), stale, "{name}");
        let after = rendered(&mut session);
        assert!(after != before, "{name} changes the picture");
        assert!(
            after == rendered(&mut Session::new(&edited, settings())),
            "{name}"
        );
    }
}

/// A moved camera has the picture of a scene that was always seen from there, but for the rounding of positions about another
/// origin; and nothing but the view is made anew.
#[test]
fn a_moved_camera_makes_nothing_anew_until_it_is_far_away() {
    let mut session = Session::owning(scene(), settings());
    rendered(&mut session);
    let edit = |x| Edit::Camera {
        number: 0,
        camera: camera(x),
    };
    session.apply(edit(0.5)).unwrap();
    assert_eq!(session.prepare().unwrap(), Stale::NONE);
    let after = rendered(&mut session);
    let moved = Scene {
        cameras: vec![camera(0.5)],
        ..scene()
    };
    let fresh = rendered(&mut Session::new(&moved, settings()));
    // Single samples may fall to the other side of an edge; the picture is the same.
    let differing = after
        .iter()
        .zip(&fresh)
        .filter(|(a, b)| (*a - *b).abs() > 1e-4);
    assert!(differing.count() * 100 <= after.len());
    session.apply(edit(1e5)).unwrap();
    assert_eq!(session.prepare().unwrap(), Stale::ALL);
}

/// A camera that leaves a medium has a picture without it, as a scene that was always seen from there.
#[test]
fn a_camera_that_leaves_a_medium_is_outside() {
    let seen = |x| {
        let mut scene = Scene {
            cameras: vec![camera(x)],
            ..scene()
        };
        let fog = MetallicRoughness {
            alpha: 0.0,
            alpha_mode: AlphaMode::Blend,
            medium: Some(Medium::absorbing([1e-3; 3], 0.1)),
            ..matte([0.0; 3])
        };
        let around = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.3),
            DQuat::IDENTITY,
            DVec3::new(0.0, 0.0, 4.0),
        );
        place(&mut scene, sphere(12, 0.0, false), fog, &[around]);
        scene
    };
    let sum = |picture: &[f32]| picture.chunks_exact(4).map(|p| p[0]).sum::<f32>();
    let mut session = Session::owning(seen(0.0), settings());
    let inside = sum(&rendered(&mut session));
    session
        .apply(Edit::Camera {
            number: 0,
            camera: camera(0.5),
        })
        .unwrap();
    assert_eq!(session.prepare().unwrap(), Stale::NONE);
    let after = sum(&rendered(&mut session));
    let fresh = sum(&rendered(&mut Session::new(&seen(0.5), settings())));
    assert!(inside < 0.1 * fresh, "{inside} {fresh}");
    assert!((after / fresh - 1.0).abs() < 1e-3, "{after} {fresh}");
}

#[test]
fn what_cannot_be_rendered_is_refused_and_nothing_changes() {
    let mut session = Session::owning(scene(), settings());
    let before = rendered(&mut session);
    let bad = Light {
        color: [f32::NAN; 3],
        ..lamp(0.0)
    };
    let refused = session.apply(Edit::Light {
        number: 0,
        light: Box::new(bad),
    });
    assert!(matches!(
        refused,
        Err(EditError::Unfit { what: "light", .. })
    ));
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let refused = session.apply(Edit::Transform {
        instance: 0,
        world_from_object: flat,
    });
    assert!(matches!(refused, Err(EditError::Unfit { .. })));
    let refused = session.apply(Edit::Camera {
        number: 3,
        camera: camera(0.0),
    });
    let message = refused.unwrap_err().to_string();
    assert_eq!(message, "the scene has no camera 3: it has 1");
    assert!(rendered(&mut session) == before);
}
