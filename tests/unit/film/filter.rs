use super::*;

fn moments(filter: &FilterTable) -> (f64, f64) {
    let n = 100_000;
    let (mut m, mut v) = (0f64, 0f64);
    for i in 0..n {
        let x = f64::from(filter.sample(Vec2::splat((i as f32 + 0.5) / n as f32)).x);
        m += x / f64::from(n);
        v += x * x / f64::from(n);
    }
    (m, v)
}

#[test]
fn filters_have_their_mean_and_variance() {
    let (m, v) = moments(&FilterTable::box_filter());
    assert!(m.abs() < 1e-5 && (v - 1.0 / 12.0).abs() < 1e-5);
    // By quadrature of the window itself.
    let shape = |x: f64| {
        let t = std::f64::consts::TAU * (x / 3.0 + 0.5);
        0.35875 - 0.48829 * t.cos() + 0.14128 * (2.0 * t).cos() - 0.01168 * (3.0 * t).cos()
    };
    let n = 200_000;
    let (mut w, mut xx) = (0f64, 0f64);
    for i in 0..n {
        let x = 3.0 * ((i as f64 + 0.5) / n as f64 - 0.5);
        w += shape(x);
        xx += x * x * shape(x);
    }
    let (m, v) = moments(&FilterTable::blackman_harris(1.5));
    assert!(
        m.abs() < 1e-4 && (v / (xx / w) - 1.0).abs() < 1e-3,
        "{v} {}",
        xx / w
    );
    let (_, v) = moments(&FilterTable::gauss(2.0));
    assert!((v / (0.5f64 * 0.5) - 1.0).abs() < 1e-3, "{v}");
}
