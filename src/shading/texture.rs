//! Texture look-ups in the precision of the image.

use crate::math::floor;
use crate::math::primaries::WorkingSpace;
use crate::math::srgb;
use crate::scene::texel::{decoded, from_u8, from_u16, rgba};
use crate::scene::{
    Image, ImageAlpha, ImageUse, Pixels, Sampler, Texture, TextureFilter, Values, Wrap,
};
use bytemuck::Pod;
use glam::{Mat3, Vec2, Vec4};
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
    /// Shares an image's values, in the precision that they have; a copy is made where opacity changes them.
    pub fn new(image: &Image, alpha: ImageAlpha) -> Self {
        let channels = image.channels.clamp(1, 4) as usize;
        let has_alpha = matches!(channels, 2 | 4);
        Self {
            width: image.width.max(1) as usize,
            height: image.height.max(1) as usize,
            channels,
            pixels: match alpha {
                ImageAlpha::Straight { .. } if has_alpha => multiplied(&image.pixels, channels),
                ImageAlpha::None if has_alpha => opaque(&image.pixels, channels),
                _ => image.pixels.clone(),
            },
        }
    }
}

/// Numbers with something done to each texel, whose last one is its opacity.
fn changed<T: Pod>(
    values: &Values<T>,
    channels: usize,
    change: impl Fn(&mut [T], &mut T),
) -> Arc<Values<T>> {
    let mut values = values.clone();
    for texel in values.chunks_exact_mut(channels) {
        if let Some((alpha, colors)) = texel.split_last_mut() {
            change(colors, alpha);
        }
    }
    Arc::new(values)
}

/// Colours multiplied with opacity. Codes are rounded down, as in Cycles.
fn multiplied(pixels: &Pixels, channels: usize) -> Pixels {
    fn of<T: Pod>(
        values: &Values<T>,
        channels: usize,
        product: impl Fn(T, T) -> T,
    ) -> Arc<Values<T>> {
        changed(values, channels, |colors, alpha| {
            colors.iter_mut().for_each(|c| *c = product(*c, *alpha));
        })
    }
    match pixels {
        Pixels::U8(p) => Pixels::U8(of(p, channels, |c, a| {
            (u16::from(c) * u16::from(a) / 255) as u8
        })),
        Pixels::U16(p) => Pixels::U16(of(p, channels, |c, a| {
            (u32::from(c) * u32::from(a) / 65_535) as u16
        })),
        Pixels::F32(p) => Pixels::F32(of(p, channels, |c, a| c * a)),
    }
}

/// The same colours without transparency.
fn opaque(pixels: &Pixels, channels: usize) -> Pixels {
    match pixels {
        Pixels::U8(p) => Pixels::U8(changed(p, channels, |_, alpha| *alpha = u8::MAX)),
        Pixels::U16(p) => Pixels::U16(changed(p, channels, |_, alpha| *alpha = u16::MAX)),
        Pixels::F32(p) => Pixels::F32(changed(p, channels, |_, alpha| *alpha = 1.0)),
    }
}

/// A texture ready to be read.
#[derive(Clone, Debug)]
pub struct PreparedTexture {
    raster: Arc<Raster>,
    sampler: Sampler,
    /// sRGB-encoded values.
    encoded: bool,
    /// They are decoded before they are interpolated.
    light: bool,
    /// From linear Rec.709 to the scene's space, for encoded colours of a scene in another one.
    to_scene: Option<Mat3>,
    /// Which coordinates.
    pub uv_set: u32,
    /// uv' = a·u + b·v + c.
    a: Vec2,
    b: Vec2,
    c: Vec2,
}

/// Where texture coordinates begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// At the upper left: v grows downwards, as in glTF.
    Upper,
    /// At the lower left: v grows upwards, as in Blender.
    Lower,
}

/// Up to four texels along an axis, with their weights; outside of the image they are transparent black.
type Taps = ([(Option<usize>, f32); 4], usize);

impl PreparedTexture {
    /// Prepares a texture of a scene whose colours are in a space. The raster is multiplied where the sampler asks for that.
    pub fn new(
        texture: &Texture,
        raster: Arc<Raster>,
        usage: ImageUse,
        space: WorkingSpace,
    ) -> Self {
        let t = &texture.transform;
        let (sin, cos) = t.rotation.sin_cos();
        let mut sampler = texture.sampler;
        let has_alpha = matches!(raster.channels, 2 | 4);
        if !has_alpha && sampler.wrap_u != Wrap::Clip {
            sampler.alpha = ImageAlpha::ChannelPacked;
        }
        // KHR_texture_transform: translation · rotation · scale, rotation with [cos, sin; −sin, cos].
        let encoded = raster.pixels.is_encoded(usage);
        let light = sampler.filter == TextureFilter::LinearLight;
        if light {
            sampler.filter = TextureFilter::Linear;
        }
        Self {
            light: light && encoded && !sampler.alpha.divides(),
            raster,
            sampler,
            encoded,
            to_scene: space
                .matrix_from_rec709()
                .filter(|_| encoded)
                .map(|matrix| matrix.as_mat3()),
            uv_set: texture.uv_set,
            a: Vec2::new(cos * t.scale[0], -sin * t.scale[0]),
            b: Vec2::new(sin * t.scale[1], cos * t.scale[1]),
            c: Vec2::from(t.offset),
        }
    }

    /// The value at texture coordinates; colours linear. Interpolation comes before decoding, as
    /// in Cycles (which keeps 8-bit images encoded too), unless the filter is of light.
    #[inline]
    pub fn read(&self, uv: Vec2) -> Vec4 {
        self.read_from(Origin::Upper, self.a * uv.x + self.b * uv.y + self.c)
    }

    /// The same at coordinates of a node, which no transform changes.
    pub fn read_upwards(&self, uv: Vec2) -> Vec4 {
        self.read_from(Origin::Lower, uv)
    }

    #[inline(always)]
    fn read_from(&self, origin: Origin, uv: Vec2) -> Vec4 {
        let channels = self.raster.channels;
        // The form a + (b − a) t: texels that are the same give their own value, to the bit.
        let mix = |a: Vec4, b: Vec4, t| a.lerp_monotonic(b, t);
        // The kind of the numbers is looked at once for all texels.
        let value = match &self.raster.pixels {
            _ if self.is_special() => self.weighted_sum(origin, uv),
            Pixels::U8(p) if self.light => {
                let codes = srgb_codes();
                let texel = |at| {
                    let light = rgba(&p[..], channels, at, |code| codes[usize::from(code)]);
                    let alpha = rgba(&p[..], channels, at, from_u8).w;
                    light.truncate().extend(alpha)
                };
                self.interpolated((origin, uv), texel, mix)
            }
            Pixels::U16(p) if self.light => {
                let texel = |at| decoded(rgba(&p[..], channels, at, from_u16));
                self.interpolated((origin, uv), texel, mix)
            }
            Pixels::U8(p) => {
                let texel = |at| rgba(&p[..], channels, at, from_u8);
                self.interpolated((origin, uv), texel, mix)
            }
            Pixels::U16(p) => {
                let texel = |at| rgba(&p[..], channels, at, from_u16);
                self.interpolated((origin, uv), texel, mix)
            }
            Pixels::F32(p) => {
                let texel = |at| rgba(&p[..], channels, at, |v| v);
                self.interpolated((origin, uv), texel, mix)
            }
        };
        let value = if self.sampler.alpha.divides() && value.w != 0.0 {
            (value.truncate() / value.w).extend(value.w)
        } else {
            value
        };
        if !self.encoded {
            return value;
        }
        // Texels of special filters are never decoded before.
        let value = if self.light && !self.is_special() {
            value
        } else {
            decoded(value)
        };
        match &self.to_scene {
            None => value,
            Some(matrix) => (*matrix * value.truncate()).extend(value.w),
        }
    }

    /// Whether its numbers, as they are stored, are 0 to 1.
    pub fn ends_at_one(&self) -> bool {
        !matches!(self.raster.pixels, Pixels::F32(_))
    }

    /// The opacity that [`Self::read`] has in its fourth place.
    #[inline]
    pub fn read_alpha(&self, uv: Vec2) -> f32 {
        if self.is_special() {
            return self.read(uv).w;
        }
        let channels = self.raster.channels;
        if !matches!(channels, 2 | 4) {
            return 1.0;
        }
        let place = (Origin::Upper, self.a * uv.x + self.b * uv.y + self.c);
        let last = channels - 1;
        let mix = |a: f32, b: f32, t| (b - a) * t + a;
        match &self.raster.pixels {
            Pixels::U8(p) => self.interpolated(place, |at| from_u8(p[at + last]), mix),
            Pixels::U16(p) => self.interpolated(place, |at| from_u16(p[at + last]), mix),
            Pixels::F32(p) => self.interpolated(place, |at| p[at + last], mix),
        }
    }

    /// Whether texels are weighed one by one: what glTF has no word for.
    #[inline]
    fn is_special(&self) -> bool {
        self.sampler.wrap_u == Wrap::Clip || self.sampler.filter == TextureFilter::Cubic
    }

    /// The texels about texture coordinates, each told by where its numbers begin, mixed as the filter has them.
    #[inline(always)]
    fn interpolated<T>(
        &self,
        (origin, uv): (Origin, Vec2),
        texel: impl Fn(usize) -> T,
        mix: impl Fn(T, T, f32) -> T,
    ) -> T {
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        let Raster {
            width,
            height,
            channels,
            ..
        } = *self.raster;
        let (wu, wv) = (self.sampler.wrap_u, self.sampler.wrap_v);
        let row = |y: usize| match origin {
            Origin::Upper => y,
            Origin::Lower => height - 1 - y,
        };
        if self.sampler.filter == TextureFilter::Nearest {
            let cell = |at: f32| match origin {
                Origin::Upper => floor(at).0,
                Origin::Lower => cell(at),
            };
            let x = wrap(cell(uv.x * width as f32), width, wu);
            let y = row(wrap(cell(uv.y * height as f32), height, wv));
            texel((y * width + x) * channels)
        } else {
            let (x, s) = floor(uv.x * width as f32 - 0.5);
            let (y, t) = floor(uv.y * height as f32 - 0.5);
            let [xa, xb] = [x, x + 1].map(|x| wrap(x, width, wu) * channels);
            let [ya, yb] = [y, y + 1].map(|y| row(wrap(y, height, wv)) * width * channels);
            let upper = mix(texel(ya + xa), texel(ya + xb), s);
            let lower = mix(texel(yb + xa), texel(yb + xb), s);
            mix(upper, lower, t)
        }
    }

    /// The sum of the texels about texture coordinates, each with its weight.
    #[cold]
    fn weighted_sum(&self, origin: Origin, uv: Vec2) -> Vec4 {
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        let Raster {
            width,
            height,
            channels,
            ref pixels,
        } = *self.raster;
        let (columns, count) = self.taps(uv.x, width, self.sampler.wrap_u);
        let (rows, row_count) = self.taps(uv.y, height, self.sampler.wrap_v);
        let mut sum = Vec4::ZERO;
        for &(y, row_weight) in &rows[..row_count] {
            for &(x, weight) in &columns[..count] {
                let (Some(x), Some(y)) = (x, y) else {
                    continue;
                };
                let y = match origin {
                    Origin::Upper => y,
                    Origin::Lower => height - 1 - y,
                };
                let texel = pixels.texel(channels, (y * width + x) * channels);
                sum += texel * (row_weight * weight);
            }
        }
        // Cycles keeps images of one number as such, and those are opaque outside, too.
        if channels == 1 {
            sum.w = 1.0;
        }
        sum
    }

    /// The texels along an axis of `n` that a coordinate of it takes.
    fn taps(&self, at: f32, n: usize, mode: Wrap) -> Taps {
        let place = |i: i64| {
            let outside = mode == Wrap::Clip && !(0..n as i64).contains(&i);
            (!outside).then(|| wrap(i, n, mode))
        };
        let none = (None, 0.0);
        if self.sampler.filter == TextureFilter::Nearest {
            let (i, _) = floor(at * n as f32);
            return ([(place(i), 1.0), none, none, none], 1);
        }
        let (i, t) = floor(at * n as f32 - 0.5);
        if self.sampler.filter == TextureFilter::Linear {
            return ([(place(i), 1.0 - t), (place(i + 1), t), none, none], 2);
        }
        // The uniform cubic B-spline.
        let s = 1.0 - t;
        let weights = [
            s * s * s / 6.0,
            (0.5 * t - 1.0) * t * t + 2.0 / 3.0,
            (0.5 * s - 1.0) * s * s + 2.0 / 3.0,
            t * t * t / 6.0,
        ];
        let mut taps = [none; 4];
        for ((tap, i), weight) in taps.iter_mut().zip(i - 1..).zip(weights) {
            *tap = (place(i), weight);
        }
        (taps, 4)
    }
}

/// What the codes of sRGB stand for.
fn srgb_codes() -> &'static [f32; 256] {
    static CODES: OnceLock<[f32; 256]> = OnceLock::new();
    CODES.get_or_init(|| std::array::from_fn(|code| srgb::decode(from_u8(code as u8))))
}

/// The texel at any place along an axis of `n` texels.
#[inline]
fn wrap(i: i64, n: usize, mode: Wrap) -> usize {
    let n = n as i64;
    if (0..n).contains(&i) {
        return i as usize;
    }
    (match mode {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp | Wrap::Clip => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    }) as usize
}

/// The texel that Cycles takes for a node: on the border of two below 0 the lower one.
fn cell(at: f32) -> i64 {
    (at as i64).saturating_sub(i64::from(at < 0.0))
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
            pixels: vec![0u8, 255, 51, 102].into(),
        };
        let texture = Texture {
            image: ImageId(0),
            uv_set: 0,
            transform,
            sampler: Sampler {
                wrap_u: wrap,
                wrap_v: wrap,
                filter,
                alpha: ImageAlpha::ChannelPacked,
            },
        };
        PreparedTexture::new(
            &texture,
            Arc::new(Raster::new(&image, ImageAlpha::ChannelPacked)),
            usage,
            WorkingSpace::default(),
        )
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
        // At -1 glTF begins with the first column again, and nodes end with the last one.
        let first = nearest.read(Vec2::new(-1.0, 0.25)).x;
        assert_eq!(first, nearest.read(Vec2::new(0.25, 0.25)).x);
        let last = nearest.read_upwards(Vec2::new(-1.0, 0.75)).x;
        assert_eq!(last, nearest.read_upwards(Vec2::new(0.75, 0.75)).x);
        assert_ne!(first, last);
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
    fn encoded_colours_are_brought_to_the_working_space_and_floats_stay() {
        let read = |pixels: Pixels, usage| {
            let image = Image {
                name: "t".into(),
                width: 1,
                height: 1,
                channels: 3,
                pixels,
            };
            let texture = Texture {
                image: ImageId(0),
                uv_set: 0,
                transform: UvTransform::default(),
                sampler: Sampler::default(),
            };
            let raster = Arc::new(Raster::new(&image, ImageAlpha::ChannelPacked));
            let texture = PreparedTexture::new(&texture, raster, usage, WorkingSpace::AcesCg);
            texture.read(Vec2::splat(0.5)).truncate()
        };
        // Cycles 5.2.3's texel of these codes in ACEScg.
        let code = read(vec![204u8, 51, 26].into(), ImageUse::Color);
        let wanted = glam::Vec3::new(0.381_84, 0.072_81, 0.025_05);
        assert!((code - wanted).abs().max_element() < 2e-4, "{code}");
        let data = read(vec![255u8, 0, 51].into(), ImageUse::Data);
        assert!((data - glam::Vec3::new(1.0, 0.0, 0.2)).length() < 1e-6);
        let light = read(vec![0.5f32, 0.25, 4.0].into(), ImageUse::Color);
        assert_eq!(light, glam::Vec3::new(0.5, 0.25, 4.0));
    }

    #[test]
    fn transparent_texels_lend_no_colour_where_opacity_weighs() {
        let read = |weighted, filter, uv: f32| {
            let image = Image {
                name: "leaf".into(),
                width: 2,
                height: 1,
                channels: 4,
                pixels: vec![0.2f32, 0.6, 0.2, 0.5, 1.0, 0.0, 0.0, 0.0].into(),
            };
            let texture = Texture {
                sampler: Sampler {
                    wrap_u: Wrap::Clamp,
                    wrap_v: Wrap::Clamp,
                    filter,
                    alpha: if weighted {
                        ImageAlpha::WEIGHTED
                    } else {
                        ImageAlpha::ChannelPacked
                    },
                },
                ..Texture::from(ImageId(0))
            };
            let raster = Arc::new(Raster::new(&image, texture.sampler.alpha));
            let space = WorkingSpace::default();
            PreparedTexture::new(&texture, raster, ImageUse::Color, space).read(Vec2::new(uv, 0.5))
        };
        let near = |a: Vec4, b: [f32; 4]| {
            assert!((a - Vec4::from(b)).abs().max_element() < 1e-6, "{a}");
        };
        // Half-way between the leaf and what is cut off.
        near(
            read(false, TextureFilter::Linear, 0.5),
            [0.6, 0.3, 0.1, 0.25],
        );
        near(
            read(true, TextureFilter::Linear, 0.5),
            [0.2, 0.6, 0.2, 0.25],
        );
        for filter in [TextureFilter::Linear, TextureFilter::Nearest] {
            near(read(true, filter, 0.25), [0.2, 0.6, 0.2, 0.5]);
            near(read(true, filter, 0.75), [0.0; 4]);
        }
    }

    #[test]
    fn outside_of_a_clipped_image_is_nothing_and_splines_smooth() {
        let read = |filter, wrap, channels: u32, uv: [f32; 2]| {
            let values = [[0.5f32; 4], [1.0; 4]].map(|texel| texel[..channels as usize].to_vec());
            let image = Image {
                name: "two".into(),
                width: 2,
                height: 1,
                channels,
                pixels: values.concat().into(),
            };
            let texture = Texture {
                sampler: Sampler {
                    wrap_u: wrap,
                    wrap_v: wrap,
                    filter,
                    alpha: ImageAlpha::ChannelPacked,
                },
                ..Texture::from(ImageId(0))
            };
            let raster = Arc::new(Raster::new(&image, texture.sampler.alpha));
            let space = WorkingSpace::default();
            let texture = PreparedTexture::new(&texture, raster, ImageUse::Color, space);
            texture.read_upwards(Vec2::from(uv))
        };
        use TextureFilter::{Cubic, Linear, Nearest};
        assert_eq!(read(Nearest, Wrap::Clip, 4, [1.1, 0.5]), Vec4::ZERO);
        assert_eq!(read(Nearest, Wrap::Clip, 4, [0.9, 0.5]), Vec4::ONE);
        // At the border half of the texel, and half of nothing.
        assert_eq!(read(Linear, Wrap::Clip, 3, [1.0, 0.5]), Vec4::splat(0.5));
        assert_eq!(
            read(Linear, Wrap::Clip, 1, [1.0, 0.5]),
            Vec4::new(0.5, 0.5, 0.5, 1.0)
        );
        // The middle of a texel has two thirds of it, and a sixth of each neighbour.
        let smoothed = read(Cubic, Wrap::Clamp, 4, [0.25, 0.5]).x;
        assert!(
            (smoothed - (5.0 / 6.0 * 0.5 + 1.0 / 6.0)).abs() < 1e-6,
            "{smoothed}"
        );
    }

    #[test]
    fn codes_are_multiplied_with_opacity_and_rounded_down() {
        let image = Image {
            name: "codes".into(),
            width: 1,
            height: 1,
            channels: 4,
            pixels: vec![200u8, 255, 7, 100].into(),
        };
        let read = |alpha| {
            let texture = Texture {
                sampler: Sampler {
                    alpha,
                    ..Sampler::default()
                },
                ..Texture::from(ImageId(0))
            };
            let raster = Arc::new(Raster::new(&image, alpha));
            let space = WorkingSpace::default();
            let texture = PreparedTexture::new(&texture, raster, ImageUse::Data, space);
            texture.read(Vec2::splat(0.5)) * 255.0
        };
        let near = |a: Vec4, b: [f32; 4]| {
            assert!((a - Vec4::from(b)).abs().max_element() < 1e-3, "{a}");
        };
        near(
            read(ImageAlpha::Straight { divided: false }),
            [78.0, 100.0, 2.0, 100.0],
        );
        near(read(ImageAlpha::WEIGHTED), [78.0 * 2.55, 255.0, 5.1, 100.0]);
        near(
            read(ImageAlpha::Premultiplied { divided: true }),
            [510.0, 650.25, 17.85, 100.0],
        );
        near(read(ImageAlpha::ChannelPacked), [200.0, 255.0, 7.0, 100.0]);
        near(read(ImageAlpha::None), [200.0, 255.0, 7.0, 255.0]);
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
