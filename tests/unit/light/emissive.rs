use super::*;

/// Triangles that emit the same everywhere.
struct Uniform(Vec<[Vec3; 3]>);

impl EmissiveSurface for Uniform {
    fn emitted(
        &self,
        (triangle, weights): (u32, Vec2),
        _: (Vec3, Vec3),
        _: f32,
    ) -> Option<EmittedPoint> {
        let [a, b, c] = self.0[triangle as usize];
        let point = a + (b - a) * weights.x + (c - a) * weights.y;
        Some(EmittedPoint {
            point: BoundedPoint {
                point,
                error: Vec3::ZERO,
            },
            radiance: Vec3::splat(3.0),
        })
    }

    fn mean_emission(&self, _: u32) -> f32 {
        3.0
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.0[triangle as usize]
    }
}

/// Of a camera far away.
pub fn eye() -> Eye {
    Eye {
        at: Vec3::splat(100.0),
        reach: 0.1,
    }
}

/// A mesh that is seen by all, with two sides.
pub fn mesh(instance: u32, triangles: Vec<[Vec3; 3]>) -> EmissiveMesh {
    EmissiveMesh {
        instance,
        visibility: Visibility::ALL,
        is_opaque: true,
        single_sided: false,
        triangles: triangles.len() as u32,
        in_triangles: false,
        object: instance,
        guess: Vec3::ONE,
        surface: Box::new(Uniform(triangles)),
    }
}

/// The halves of a square with its middle at a point, in a plane of equal z.
pub fn halves(middle: Vec3, size: f32) -> [[Vec3; 3]; 2] {
    let corner = |x: f32, y: f32| middle + Vec3::new(x, y, 0.0) * (0.5 * size);
    let [a, b, c, d] =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y));
    [[a, b, c], [a, c, d]]
}

/// A square that emits 3 everywhere, or its half below the diagonal.
pub fn square(middle: Vec3, size: f32, whole: bool) -> Vec<Light> {
    let triangles = halves(middle, size)[..if whole { 2 } else { 1 }].to_vec();
    let mut lights = Vec::new();
    EmissiveTriangles::default().add(mesh(0, triangles), &eye(), None, &mut lights);
    lights
}

#[test]
fn halves_of_a_rectangle_are_one_light_and_triangles_know_theirs() {
    let [a, b] = halves(Vec3::Z, 1.0);
    let alone = [Vec3::X * 5.0, Vec3::X * 6.0, Vec3::new(5.0, 1.0, 3.0)];
    let (mut lights, mut triangles) = (Vec::new(), EmissiveTriangles::default());
    triangles.add(mesh(3, vec![alone, a, b]), &eye(), None, &mut lights);
    triangles.add(mesh(1, vec![alone]), &eye(), None, &mut lights);
    assert!(matches!(
        lights[..],
        [Light::Triangle(_), Light::Rectangle(_), Light::Triangle(_)]
    ));
    let of = |instance: u32| (0..3).map(move |triangle| (instance, triangle));
    let found: Vec<_> = of(3).map(|(i, t)| triangles.light(i, t)).collect();
    assert_eq!(found, [Some(0), Some(1), Some(1)]);
    assert_eq!(triangles.light(1, 0), Some(2));
    assert_eq!([0, 2, 4].map(|i| triangles.light(i, 0)), [None; 3]);
}

/// Of two opaque triangles with one side that stand in one place, turned over, one is a light. Without back faces, each is.
#[test]
fn twins_are_one_light() {
    let [[a, b, c], _] = halves(Vec3::Z, 1.0);
    for (twins, count) in [(Some(Twins::default()), 1), (None, 2)] {
        let (mut lights, mut triangles) = (Vec::new(), EmissiveTriangles::default());
        let mut twins = twins;
        for (instance, corners) in [[a, b, c], [a, c, b]].into_iter().enumerate() {
            let mut one = mesh(instance as u32, vec![corners]);
            one.single_sided = true;
            triangles.add(one, &eye(), twins.as_mut(), &mut lights);
        }
        assert_eq!(lights.len(), count);
        assert_eq!(triangles.light(1, 0), Some(count as u32 - 1));
    }
}

/// One mesh may be hidden from rays that see the other.
#[test]
fn what_other_rays_see_is_no_twin() {
    let [[a, b, c], _] = halves(Vec3::Z, 1.0);
    let (mut lights, mut triangles) = (Vec::new(), EmissiveTriangles::default());
    let mut twins = Twins::default();
    for (instance, visibility) in [
        Visibility::ALL,
        Visibility::ALL.without(crate::scene::RayKind::Camera),
    ]
    .into_iter()
    .enumerate()
    {
        let one = EmissiveMesh {
            visibility,
            single_sided: true,
            ..mesh(instance as u32, vec![[a, b, c]])
        };
        triangles.add(one, &eye(), Some(&mut twins), &mut lights);
    }
    assert_eq!(lights.len(), 2);
}
