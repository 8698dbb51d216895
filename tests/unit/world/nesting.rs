use super::*;

/// Solids of these priorities; none that take no part.
fn order(priorities: &[Option<i32>]) -> Nesting {
    let solids = priorities.iter().map(|priority| {
        priority.map(|priority| Solid {
            priority,
            ior: 1.5,
            dispersion: 0.0,
        })
    });
    Nesting {
        solids: solids.collect(),
    }
}

fn within(objects: &[u32]) -> Objects {
    objects.iter().copied().collect()
}

#[test]
fn the_highest_priority_is_there_and_of_equals_the_last_entered() {
    let order = order(&[Some(0), Some(2), Some(2), None]);
    assert_eq!(order.top(&within(&[])), None);
    assert_eq!(order.top(&within(&[3])), None);
    assert_eq!(order.top(&within(&[1, 0, 3])), Some(1));
    assert_eq!(order.top(&within(&[1, 2, 0])), Some(2));
    assert_eq!(order.top(&within(&[2, 1])), Some(1));
}

#[test]
fn an_interface_is_there_where_nothing_above_it_is() {
    let order = order(&[Some(0), Some(2), Some(2), None]);
    // Entered, within what was entered before.
    assert!(!order.is_there(0, &within(&[1, 0])));
    assert!(order.is_there(2, &within(&[1, 2])));
    // Left, where the other was entered later.
    assert!(!order.is_there(1, &within(&[1, 2])));
    // What takes no part is always there, and is nobody's rival.
    assert!(order.is_there(3, &within(&[1, 3])));
    assert!(order.is_there(0, &within(&[0, 3])));
    // Left without having been entered: an open mesh.
    assert!(order.is_there(1, &within(&[2])));
    assert!(!order.is_there(0, &within(&[2])));
}

#[test]
fn the_other_side_is_what_is_left_without_the_solid() {
    let mut order = order(&[Some(0), Some(2), None]);
    let index = |order: &Nesting, objects: &[u32], wavelength| {
        order.beside(1, &within(objects), wavelength).index
    };
    assert_eq!(index(&order, &[1], 0.0), 0.0);
    assert_eq!(index(&order, &[2, 1], 0.0), 0.0);
    assert_eq!(index(&order, &[0, 1], 0.0), 1.5);
    if let Some(solid) = &mut order.solids[0] {
        solid.dispersion = 1.0;
    }
    assert_eq!(index(&order, &[0, 1], 0.0), 1.5);
    assert_eq!(index(&order, &[0, 1], 450.0), index_at(1.5, 1.0, 450.0));
}
