use super::*;

fn curves(basis: Basis, wrap: Wrap, points: &[[f32; 3]]) -> Curves {
    Curves {
        basis,
        wrap,
        counts: vec![points.len()],
        points: points.to_vec(),
    }
}

fn at(curves: &Curves, sample: &Sample) -> DVec3 {
    let sum = sample
        .points
        .iter()
        .map(|(i, share)| *share * DVec3::from(curves.points[*i as usize].map(f64::from)));
    sum.sum()
}

const BASES: [Basis; 4] = [
    Basis::Linear,
    Basis::Bezier,
    Basis::BSpline,
    Basis::CatmullRom,
];
const POINTS: [[f32; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [1.0, 2.0, 0.5],
    [2.0, -1.0, 0.0],
    [3.0, 0.0, 1.0],
    [4.0, 1.0, -1.0],
    [5.0, 1.0, 0.0],
    [6.0, 3.0, 0.0],
];

#[test]
fn shares_sum_to_one() {
    for basis in BASES {
        for t in [0.0, 0.25, 0.7, 1.0] {
            let sum: f64 = basis.shares(t).iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "{basis:?} {t}");
        }
    }
}

/// The numbers of segments that UsdGeomBasisCurves has for each basis and each end.
#[test]
fn there_are_as_many_segments_as_usd_says() {
    let count = |basis, wrap, points| curves(basis, wrap, &[]).segments(points);
    assert_eq!(count(Basis::Linear, Wrap::Open, 4), 3);
    assert_eq!(count(Basis::Linear, Wrap::Closed, 4), 4);
    assert_eq!(count(Basis::Bezier, Wrap::Open, 7), 2);
    assert_eq!(count(Basis::Bezier, Wrap::Closed, 6), 2);
    assert_eq!(count(Basis::BSpline, Wrap::Open, 7), 4);
    assert_eq!(count(Basis::CatmullRom, Wrap::Closed, 7), 7);
    assert_eq!(count(Basis::BSpline, Wrap::Pinned, 7), 6);
    for points in 0..4 {
        assert_eq!(count(Basis::Bezier, Wrap::Open, points), 0);
    }
}

#[test]
fn ends_are_reached_and_segments_meet() {
    for basis in BASES {
        for wrap in [Wrap::Open, Wrap::Closed, Wrap::Pinned] {
            let points = if basis == Basis::Bezier && wrap == Wrap::Closed {
                6
            } else {
                7
            };
            let curves = curves(basis, wrap, &POINTS[..points]);
            let segments = curves.segments(points);
            let place = |segment, t| at(&curves, &curves.sample((0, 0, 0), (segment, segments), t));
            for segment in 1..segments {
                let gap = place(segment - 1, 1.0) - place(segment, 0.0);
                assert!(gap.length() < 1e-9, "{basis:?} {wrap:?} {segment}");
            }
            let point = |i: usize| DVec3::from(POINTS[i].map(f64::from));
            if wrap == Wrap::Closed {
                assert!((place(segments - 1, 1.0) - place(0, 0.0)).length() < 1e-9);
            } else if wrap == Wrap::Pinned && basis != Basis::Bezier {
                assert!((place(0, 0.0) - point(0)).length() < 1e-9, "{basis:?}");
                assert!(
                    (place(segments - 1, 1.0) - point(6)).length() < 1e-9,
                    "{basis:?}"
                );
            }
        }
    }
}

/// A pinned curve of two points is the line between them.
#[test]
fn two_points_are_enough_for_pinned_ends() {
    for basis in [Basis::BSpline, Basis::CatmullRom] {
        let curves = curves(basis, Wrap::Pinned, &POINTS[..2]);
        let place = at(&curves, &curves.sample((0, 0, 0), (0, 1), 0.5));
        assert!(
            (place - DVec3::new(0.5, 1.0, 0.25)).length() < 1e-9,
            "{basis:?}"
        );
    }
}

/// A closed tube is as watertight as an open one: each edge has two faces.
#[test]
fn tubes_are_closed_and_look_outwards() {
    let ring: Vec<DVec3> = (0..12)
        .map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / 12.0).sin_cos();
            DVec3::new(cos, sin, 0.2 * (3.0 * sin))
        })
        .collect();
    for closed in [false, true] {
        let mut builder = Builder {
            polygons: Polygons::new(Vec::new()),
            normals: Vec::new(),
            of_point: Vec::new(),
            around: 6,
        };
        builder.tube(0, &ring, &[0.1; 12], closed);
        // The volume under the faces, outwards positive.
        let point = |i: u32| DVec3::from(builder.polygons.points[i as usize].map(f64::from));
        let mut volume = 0.0;
        let mut start = 0;
        for count in &builder.polygons.counts {
            let face = &builder.polygons.corners[start..start + count];
            for pair in face[1..].windows(2) {
                volume += point(face[0]).dot(point(pair[0]).cross(point(pair[1]))) / 6.0;
            }
            start += count;
        }
        let length: f64 = (0..if closed { 12 } else { 11 })
            .map(|i: usize| ring[i].distance(ring[(i + 1) % 12]))
            .sum();
        let corner = PI / 6.0;
        let radius = 0.1 * corner / corner.sin();
        let area = 3.0 * (2.0 * corner).sin() * radius * radius;
        assert!(
            (volume / (length * area) - 1.0).abs() < 0.05,
            "{closed}: {volume}"
        );
    }
}
