use super::*;

#[test]
fn flat_pictures_have_the_formulas_first_factor() {
    let value = ssim(16, 13, &|_| [[0.25; 3], [0.75; 3]]).unwrap();
    let expected = (2.0 * 0.25 * 0.75 + C1) / (0.25 * 0.25 + 0.75 * 0.75 + C1);
    assert!((value - expected).abs() < 1e-12, "{value}");
    let same = ssim(11, 11, &|at| [[at as f32 / 121.0; 3]; 2]).unwrap();
    assert!((same - 1.0).abs() < 1e-12);
}

#[test]
fn structure_turned_around_is_negative() {
    // A checkerboard and its opposite have the same mean and the covariance -1/4 of a window's variance nearly.
    let value = ssim(31, 200, &|at| {
        let white = (at % 31 + at / 31) % 2 == 0;
        let value = if white { 1.0 } else { 0.0 };
        [[value; 3], [1.0 - value; 3]]
    })
    .unwrap();
    assert!(value < -0.99, "{value}");
}

#[test]
fn pictures_without_room_for_a_window_have_none() {
    assert_eq!(ssim(10, 100, &|_| [[0.0; 3]; 2]), None);
    assert_eq!(ssim(100, 10, &|_| [[0.0; 3]; 2]), None);
    assert!(ssim(11, 11, &|_| [[0.0; 3]; 2]).is_some());
}
