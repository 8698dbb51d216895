use super::*;
use crate::scene::coincident::Plane;
use glam::Vec3;
use proptest::prelude::*;

fn flat(corners: [[f32; 2]; 3]) -> Flat {
    Flat {
        plane: Plane::through(Vec3::ZERO, 0),
        corners: corners.map(Vec2::from),
        instance: 0,
        triangle: 0,
    }
}

fn by_pairs(group: &[Flat]) -> Vec<usize> {
    let meets = |one: usize| {
        (0..group.len()).any(|other| {
            let bounds = overlap(group[one].bounds(), group[other].bounds());
            other != one && bounds && meet(&group[one], &group[other])
        })
    };
    (0..group.len()).filter(|&one| meets(one)).collect()
}

proptest! {
    /// Small triangles in a wide plane: whatever the grid finds, all pairs do.
    #[test]
    fn a_grid_finds_what_all_pairs_find(
        triangles in prop::collection::vec(((-9f32..9.0, -9f32..9.0), prop::array::uniform4(-0.7f32..0.7)), 20..150)
    ) {
        let group: Vec<Flat> = triangles
            .iter()
            .map(|&((x, y), [a, b, c, d])| flat([[x, y], [x + a, y + b], [x + c, y + d]]))
            .collect();
        prop_assert_eq!(overlapping(&group, |_, _| true), Some(by_pairs(&group)));
    }
}

/// Squares side by side touch and do not overlap; a floor under all of them, or all in one place, is left to the tree.
#[test]
fn a_floor_of_squares_lies_alone() {
    let square = |x: f32, y: f32| {
        let (x, y) = (0.1 * x, 0.1 * y);
        let (right, above) = (x + 0.1, y + 0.1);
        [
            flat([[x, y], [right, y], [right, above]]),
            flat([[x, y], [right, above], [x, above]]),
        ]
    };
    let places = (0..40).flat_map(|x| (0..40).map(move |y| (x as f32, y as f32)));
    let mut floor: Vec<Flat> = places.flat_map(|(x, y)| square(x, y)).collect();
    assert_eq!(overlapping(&floor, |_, _| true), Some(Vec::new()));
    floor.extend(square(7.0, 7.0));
    let found = overlapping(&floor, |_, _| true);
    assert_eq!(found.map(|found| found.len()), Some(4));
    floor.push(flat([[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]]));
    assert_eq!(overlapping(&floor, |_, _| true), None);
    let heap: Vec<Flat> = (0..MOST_IN_CELL + 1)
        .flat_map(|_| square(0.0, 0.0))
        .collect();
    assert_eq!(overlapping(&heap, |_, _| true), None);
}
