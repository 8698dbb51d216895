use super::*;

#[test]
fn windows_are_widened_about_their_middle() {
    let window = Window {
        left: -1.0,
        right: 3.0,
        bottom: 0.0,
        top: 2.0,
    };
    assert_eq!(window.aspect(), 2.0);
    assert_eq!(window.widened_to(2.0), window);
    let wide = window.widened_to(4.0);
    assert_eq!(
        (wide.left, wide.right, wide.bottom, wide.top),
        (-3.0, 5.0, 0.0, 2.0)
    );
    let tall = window.widened_to(1.0);
    assert_eq!(
        (tall.left, tall.right, tall.bottom, tall.top),
        (-1.0, 3.0, -1.0, 3.0)
    );
}
