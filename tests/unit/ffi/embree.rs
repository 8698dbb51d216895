use super::*;
use std::sync::atomic::{AtomicBool, Ordering};

fn quad(z: f32) -> Arc<TriangleMesh> {
    Arc::new(
        TriangleMesh::new(
            vec![
                [-1.0, -1.0, z],
                [1.0, -1.0, z],
                [1.0, 1.0, z],
                [-1.0, 1.0, z],
            ],
            vec![[0, 1, 2], [0, 2, 3]],
        )
        .unwrap(),
    )
}

fn down(x: f32, y: f32) -> Ray {
    Ray {
        origin: [x, y, 10.0],
        direction: [0.0, 0.0, -1.0],
        near: 0.0,
        far: f32::INFINITY,
        mask: u32::MAX,
        time: 0.0,
    }
}

#[test]
fn the_library_fits_the_headers() {
    let device = Device::new(None, None).unwrap();
    assert!(
        device.version()
            >= Version {
                major: 4,
                minor: 3,
                patch: 0
            }
    );
    assert_eq!(size_of::<sys::RTCRayHit>(), 96);
}

/// See [`Device::new`]: no device comes or goes meanwhile.
#[test]
fn devices_may_be_asked_for_while_others_build() {
    let device = Device::new(Some(2), None).unwrap();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for threads in [Some(1), None] {
            let stop = &stop;
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    drop(Device::new(threads, None).unwrap());
                    std::thread::yield_now();
                }
            });
        }
        // oneTBB's scheduler is held by threads that have used it: these come and go.
        for _ in 0..4000 {
            scope
                .spawn(|| Scene::new(&device, true).unwrap().commit().unwrap())
                .join()
                .unwrap();
        }
        stop.store(true, Ordering::Relaxed);
    });
    let same = |a: &Device, b: &Device| Arc::ptr_eq(&a.0, &b.0);
    assert!(same(&device, &Device::new(Some(2), None).unwrap()));
    assert!(!same(&device, &Device::new(Some(1), None).unwrap()));
}

#[test]
fn errors_stay_with_the_thread_that_made_them() {
    let device = Device::new(Some(1), None).unwrap();
    // SAFETY: the device is alive; it refuses to change what can only be read.
    unsafe { sys::rtcSetDeviceProperty(device.0.raw, sys::RTC_DEVICE_PROPERTY_VERSION, 1) };
    std::thread::scope(|scope| {
        scope.spawn(|| take_error().unwrap()).join().unwrap();
    });
    assert!(take_error().is_err());
    assert!(take_error().is_ok());
}

#[test]
fn a_broken_index_is_refused() {
    assert!(TriangleMesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 3]]).is_err());
}

#[test]
fn hits_name_geometry_triangle_and_barycentrics() {
    let device = Device::new(Some(1), None).unwrap();
    let mut scene = Scene::new(&device, true).unwrap();
    assert_eq!(scene.add_triangles(&quad(0.0), false, u32::MAX).unwrap(), 0);
    assert_eq!(scene.add_triangles(&quad(2.0), false, u32::MAX).unwrap(), 1);
    let scene = scene.commit().unwrap();
    let hit = scene.intersect(&down(0.5, -0.25)).unwrap();
    assert_eq!((hit.geometry, hit.primitive, hit.instance), (1, 0, None));
    assert!((hit.distance - 8.0).abs() < 1e-5);
    let w = 1.0 - hit.u - hit.v;
    // Corners (-1,-1), (1,-1), (1,1).
    assert!((-w + hit.u + hit.v - 0.5).abs() < 1e-6 && (-w - hit.u + hit.v + 0.25).abs() < 1e-6);
    assert!(scene.intersect(&down(1.5, 0.0)).is_none());
    assert!(scene.occluded(&down(0.5, 0.5)));
    assert!(!scene.occluded(&Ray {
        far: 7.9,
        ..down(0.5, 0.5)
    }));
}

#[test]
fn filters_let_rays_through() {
    let device = Device::new(Some(1), None).unwrap();
    let mut scene = Scene::new(&device, true).unwrap();
    scene.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
    scene.add_triangles(&quad(2.0), true, u32::MAX).unwrap();
    scene.add_triangles(&quad(4.0), true, u32::MAX).unwrap();
    let scene = scene.commit().unwrap();
    let hit = scene
        .intersect_filtered(&down(0.5, 0.1), |h| h.geometry == 1)
        .unwrap();
    assert_eq!(hit.geometry, 1);
    let mut asked = Vec::new();
    let hit = scene
        .intersect_filtered(&down(0.5, 0.1), |h| {
            asked.push(h.geometry);
            false
        })
        .unwrap();
    assert_eq!(hit.geometry, 0, "the unfiltered geometry is always hit");
    asked.sort_unstable();
    assert_eq!(asked, [1, 2]);
    let mut seen = 0;
    assert!(!scene.occluded_filtered(
        &Ray {
            far: 9.0,
            ..down(0.5, 0.1)
        },
        |_| {
            seen += 1;
            false
        }
    ));
    assert_eq!(seen, 2);
}

#[test]
fn instances_are_placed_and_named() {
    let device = Device::new(Some(2), None).unwrap();
    let mut child = Scene::new(&device, true).unwrap();
    child.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
    let child = child.commit().unwrap();
    let mut top = Scene::new(&device, true).unwrap();
    for x in [0.0, 10.0] {
        top.add_instance(
            &child,
            &[
                [2.0, 0.0, 0.0],
                [0.0, 2.0, 0.0],
                [0.0, 0.0, 2.0],
                [x, 0.0, 1.0],
            ],
            u32::MAX,
        )
        .unwrap();
    }
    let top = top.commit().unwrap();
    drop(child);
    let hit = top.intersect(&down(11.5, 1.5)).unwrap();
    assert_eq!((hit.geometry, hit.instance), (0, Some(1)));
    assert!((hit.distance - 9.0).abs() < 1e-5);
}

#[test]
fn masks_hide_geometries_and_instances() {
    let device = Device::new(Some(1), None).unwrap();
    let mut child = Scene::new(&device, true).unwrap();
    child.add_triangles(&quad(0.0), false, u32::MAX).unwrap();
    let child = child.commit().unwrap();
    let mut top = Scene::new(&device, true).unwrap();
    top.add_triangles(&quad(4.0), false, 1).unwrap();
    let identity = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0],
    ];
    top.add_instance(&child, &identity, 2).unwrap();
    let top = top.commit().unwrap();
    let nearest = |mask| {
        let ray = Ray {
            mask,
            ..down(0.5, 0.1)
        };
        let hit = top.intersect(&ray);
        assert_eq!(top.occluded(&ray), hit.is_some());
        hit.map(|h| h.distance.round())
    };
    assert_eq!(
        [nearest(1), nearest(2), nearest(3), nearest(4)],
        [Some(6.0), Some(10.0), Some(6.0), None]
    );
}

#[test]
fn spheres_are_hit_and_filtered() {
    let device = Device::new(Some(1), None).unwrap();
    let mut scene = Scene::new(&device, true).unwrap();
    scene
        .add_spheres(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 5.0, 0.5]])
        .unwrap();
    let scene = scene.commit().unwrap();
    let mut seen = Vec::new();
    scene.intersect_filtered(&down(0.1, 0.1), |h| {
        seen.push(h.primitive);
        false
    });
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen, [0, 1]);
}
