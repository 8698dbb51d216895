use super::*;
use crate::sampler::hashed;

fn aperture(blades: u32, rotation: f32, ratio: f32) -> Aperture {
    Aperture {
        radius: 0.5,
        blades,
        rotation,
        ratio,
        focus_distance: 1.0,
    }
}

/// Whether a point lies in the opening, by the half-planes of its edges; a last place of slack.
fn contains(a: &Aperture, p: Vec2) -> bool {
    let q = Vec2::new(p.x * a.ratio, p.y) / a.radius;
    if a.blades < 3 {
        return q.length() <= 1.0 + 1e-6;
    }
    let n = a.blades as f32;
    (0..a.blades).all(|i| {
        let angle = a.rotation + i as f32 * TAU / n;
        q.dot(Vec2::new(angle.cos(), angle.sin())) <= (PI / n).cos() + 1e-6
    })
}

/// χ² over a grid of the cells that lie wholly in the opening: 40 000 points; each cell's share of the
/// area is exact. Bound: mean + 5 σ of χ² with k degrees of freedom is k + 5 √(2 k).
#[test]
fn points_are_uniform_over_the_opening_and_nowhere_else() {
    for (blades, rotation, ratio) in [
        (0, 0.0, 1.0),
        (2, 1.0, 2.0),
        (3, 0.0, 1.0),
        (5, 0.7, 1.0),
        (6, -0.3, 0.5),
        (16, 2.0, 1.5),
    ] {
        let a = aperture(blades, rotation, ratio);
        let n = 40_000u32;
        let cells = 24i32;
        let size = 2.0 * a.radius / cells as f32 * (1.0 / ratio).max(1.0);
        let mut counts = std::collections::HashMap::new();
        for i in 0..n {
            let p = a.sample(Vec2::new(hashed(7, i, blades), hashed(8, i, blades)));
            assert!(contains(&a, p), "{a:?} {p}");
            let cell = ((p.x / size).floor() as i32, (p.y / size).floor() as i32);
            *counts.entry(cell).or_insert(0u32) += 1;
        }
        let unit_area = if blades < 3 {
            PI
        } else {
            0.5 * blades as f32 * (TAU / blades as f32).sin()
        };
        let area = unit_area * a.radius * a.radius / ratio;
        let expected = f64::from(n) * f64::from(size * size / area);
        let (mut chi2, mut k) = (0.0, 0.0);
        for x in -cells..cells {
            for y in -cells..cells {
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .map(|(i, j)| Vec2::new((x + i) as f32, (y + j) as f32) * size);
                if corners.iter().all(|&c| contains(&a, c)) {
                    let count = f64::from(counts.get(&(x, y)).copied().unwrap_or(0));
                    chi2 += (count - expected).powi(2) / expected;
                    k += 1.0;
                }
            }
        }
        assert!(k > 50.0, "{a:?}: {k} cells");
        assert!(chi2 < k + 5.0 * (2.0f64 * k).sqrt(), "{a:?}: {chi2} of {k}");
    }
}

/// Cycles' sense: at rotation 0 an edge's middle is to the right, and rotation turns it up.
#[test]
fn the_polygon_turns_counter_clockwise_from_an_edge_to_the_right() {
    let widest = |rotation: f32, axis: Vec2| {
        (0..4000)
            .map(|i| aperture(3, rotation, 1.0).sample(Vec2::new(hashed(1, i, 0), hashed(2, i, 0))))
            .map(|p| p.dot(axis))
            .fold(f32::NEG_INFINITY, f32::max)
    };
    // Half the radius to the edge, the whole radius to the corner opposite of it.
    assert!((widest(0.0, Vec2::X) - 0.25).abs() < 0.01);
    assert!(widest(0.0, Vec2::NEG_X) > 0.47);
    assert!((widest(PI / 2.0, Vec2::Y) - 0.25).abs() < 0.01);
    assert!(widest(PI / 2.0, Vec2::NEG_Y) > 0.47);
}
