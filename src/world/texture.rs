//! Texture look-ups in the precision of the image.

use crate::scene::{Image, ImageUse, Pixels, Sampler, Texture, TextureFilter, Wrap};
use glam::{Vec2, Vec4};
use std::sync::{Arc, OnceLock};

/// An image as textures read it: shared by all textures that refer to it.
#[derive(Debug)]
pub struct Raster {
    width: usize,
    height: usize,
    channels: usize,
    pixels: Pixels,
}

impl Raster {
    /// Takes a copy of an image's values.
    pub fn new(image: &Image) -> Self {
        Self {
            width: image.width.max(1) as usize,
            height: image.height.max(1) as usize,
            channels: image.channels.clamp(1, 4) as usize,
            pixels: image.pixels.clone(),
        }
    }

    #[inline]
    fn texel(&self, x: usize, y: usize) -> Vec4 {
        let at = (y * self.width + x) * self.channels;
        let value = |c: usize| match &self.pixels {
            Pixels::U8(p) => f32::from(p[at + c]) * (1.0 / 255.0),
            Pixels::U16(p) => f32::from(p[at + c]) * (1.0 / 65535.0),
            Pixels::F32(p) => p[at + c],
        };
        match self.channels {
            1 => {
                let v = value(0);
                Vec4::new(v, v, v, 1.0)
            }
            2 => {
                let v = value(0);
                Vec4::new(v, v, v, value(1))
            }
            3 => Vec4::new(value(0), value(1), value(2), 1.0),
            _ => Vec4::new(value(0), value(1), value(2), value(3)),
        }
    }
}

/// A texture ready to be read.
#[derive(Clone, Debug)]
pub struct PreparedTexture {
    raster: Arc<Raster>,
    sampler: Sampler,
    /// sRGB-encoded values.
    encoded: bool,
    /// Which coordinates.
    pub uv_set: u32,
    /// uv' = a·u + b·v + c.
    a: Vec2,
    b: Vec2,
    c: Vec2,
}

/// sRGB to linear (IEC 61966-2-1), tabulated: linear interpolation between 4096 points errs by
/// less than 2e-7 (step² / 8 · max f'' = (1/4096)² / 8 · 3.5).
fn srgb_to_linear(x: f32) -> f32 {
    const STEPS: usize = 4096;
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        (0..=STEPS)
            .map(|i| {
                let x = i as f64 / STEPS as f64;
                (if x <= 0.04045 {
                    x / 12.92
                } else {
                    ((x + 0.055) / 1.055).powf(2.4)
                }) as f32
            })
            .collect()
    });
    let x = x.clamp(0.0, 1.0) * STEPS as f32;
    let i = (x as usize).min(STEPS - 1);
    let t = x - i as f32;
    table[i] * (1.0 - t) + table[i + 1] * t
}

impl PreparedTexture {
    /// Prepares a texture of a scene.
    pub fn new(texture: &Texture, raster: Arc<Raster>, usage: ImageUse) -> Self {
        let t = &texture.transform;
        let (sin, cos) = t.rotation.sin_cos();
        // KHR_texture_transform: translation · rotation · scale, rotation with [cos, sin; −sin, cos].
        let encoded = usage == ImageUse::Color && !matches!(raster.pixels, Pixels::F32(_));
        Self {
            raster,
            sampler: texture.sampler,
            encoded,
            uv_set: texture.uv_set,
            a: Vec2::new(cos * t.scale[0], -sin * t.scale[0]),
            b: Vec2::new(sin * t.scale[1], cos * t.scale[1]),
            c: Vec2::from(t.offset),
        }
    }

    /// The value at texture coordinates; colours linear. Interpolation comes before decoding, as
    /// in Cycles (which keeps 8-bit images encoded too).
    #[inline]
    pub fn read(&self, uv: Vec2) -> Vec4 {
        let uv = self.a * uv.x + self.b * uv.y + self.c;
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        let r = &*self.raster;
        let value = match self.sampler.filter {
            TextureFilter::Nearest => {
                let x = wrap(floor(uv.x * r.width as f32), r.width, self.sampler.wrap_u);
                let y = wrap(floor(uv.y * r.height as f32), r.height, self.sampler.wrap_v);
                r.texel(x, y)
            }
            TextureFilter::Linear => {
                let (x, y) = (uv.x * r.width as f32 - 0.5, uv.y * r.height as f32 - 0.5);
                let (s, t) = (x - x.floor(), y - y.floor());
                let (x0, y0) = (floor(x), floor(y));
                let (wu, wv) = (self.sampler.wrap_u, self.sampler.wrap_v);
                let (xa, xb) = (wrap(x0, r.width, wu), wrap(x0 + 1, r.width, wu));
                let (ya, yb) = (wrap(y0, r.height, wv), wrap(y0 + 1, r.height, wv));
                r.texel(xa, ya)
                    .lerp(r.texel(xb, ya), s)
                    .lerp(r.texel(xa, yb).lerp(r.texel(xb, yb), s), t)
            }
        };
        if self.encoded {
            Vec4::new(
                srgb_to_linear(value.x),
                srgb_to_linear(value.y),
                srgb_to_linear(value.z),
                value.w,
            )
        } else {
            value
        }
    }
}

fn floor(x: f32) -> i64 {
    x.floor() as i64
}

/// The texel at any place along an axis of `n` texels.
#[inline]
fn wrap(i: i64, n: usize, mode: Wrap) -> usize {
    let n = n as i64;
    (match mode {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ImageId, UvTransform};

    fn texture(
        filter: TextureFilter,
        wrap: Wrap,
        usage: ImageUse,
        transform: UvTransform,
    ) -> PreparedTexture {
        let image = Image {
            name: "t".into(),
            width: 2,
            height: 2,
            channels: 1,
            pixels: Pixels::U8(vec![0, 255, 51, 102]),
        };
        let texture = Texture {
            image: ImageId(0),
            uv_set: 0,
            transform,
            sampler: Sampler {
                wrap_u: wrap,
                wrap_v: wrap,
                filter,
            },
        };
        PreparedTexture::new(&texture, Arc::new(Raster::new(&image)), usage)
    }

    #[test]
    fn texels_wraps_and_interpolation_are_where_gltf_has_them() {
        let nearest = texture(
            TextureFilter::Nearest,
            Wrap::Repeat,
            ImageUse::Data,
            UvTransform::default(),
        );
        assert_eq!(
            nearest.read(Vec2::new(0.25, 0.25)).x,
            0.0,
            "the first texel is at the top left, v grows downwards"
        );
        assert_eq!(nearest.read(Vec2::new(0.75, 0.25)).x, 1.0);
        assert!((nearest.read(Vec2::new(1.25, -0.25)).x - 0.2).abs() < 1e-6);
        let mirror = texture(
            TextureFilter::Nearest,
            Wrap::Mirror,
            ImageUse::Data,
            UvTransform::default(),
        );
        assert_eq!(mirror.read(Vec2::new(1.25, 0.25)).x, 1.0);
        let clamp = texture(
            TextureFilter::Linear,
            Wrap::Clamp,
            ImageUse::Data,
            UvTransform::default(),
        );
        assert_eq!(clamp.read(Vec2::new(-3.0, 0.0)).x, 0.0);
        assert!((clamp.read(Vec2::new(0.5, 0.25)).x - 0.5).abs() < 1e-6);
        let color = texture(
            TextureFilter::Nearest,
            Wrap::Clamp,
            ImageUse::Color,
            UvTransform::default(),
        );
        assert!((color.read(Vec2::new(0.75, 0.75)).x - 0.132_868).abs() < 1e-5);
    }

    #[test]
    fn the_texture_transform_is_scale_then_rotation_then_offset() {
        let transform = UvTransform {
            offset: [0.5, 0.0],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: [2.0, 1.0],
        };
        let t = texture(
            TextureFilter::Nearest,
            Wrap::Repeat,
            ImageUse::Data,
            transform,
        );
        // The extension's matrix: u' = cos·su·u + sin·sv·v + ou, v' = −sin·su·u + cos·sv·v + ov.
        let uv = t.a * 0.1 + t.b * 0.2 + t.c;
        assert!((uv - Vec2::new(0.7, -0.2)).length() < 1e-6, "{uv}");
    }
}
