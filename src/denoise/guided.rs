//! Filters for the pictures of one render: their guides are prepared once.

use super::passes::Albedo;
use super::{DenoiseError, Prefilter, Settings, layer};
use crate::ffi::oidn::{Device, Filter, Image, Library, Role};
use crate::film::Picture;
use std::borrow::Cow;
use std::cell::OnceCell;

/// What stands for the albedo where it says nothing of a pass: one grey everywhere, as in Cycles (`denoiser_oidn_base.cpp`).
const GREY: f32 = 0.5;

/// Tells whether it is still wanted.
pub(super) type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

struct Guide<'a> {
    role: Role,
    data: Cow<'a, [f32]>,
    channels: usize,
}

/// A device with the guides of a picture.
pub(super) struct Guided<'a> {
    device: Device<'a>,
    size: (u32, u32),
    settings: &'a Settings,
    guides: Vec<Guide<'a>>,
    grey: OnceCell<Vec<f32>>,
    cancelled: Cancelled<'a>,
}

impl<'a> Guided<'a> {
    /// With the guides that a picture has, which are denoised first where they are to be.
    pub(super) fn new(
        library: &'a Library,
        settings: &'a Settings,
        picture: &'a Picture,
        cancelled: Cancelled<'a>,
    ) -> Result<Self, DenoiseError> {
        let mut guided = Self {
            device: Device::new(library, settings.threads)?,
            size: (picture.width, picture.height),
            settings,
            guides: Vec::new(),
            grey: OnceCell::new(),
            cancelled,
        };
        let mut guides = Vec::new();
        for (pass, role) in settings.guides.passes() {
            let guide = layer(picture, *pass)?;
            let channels = guide.channels.len();
            let mut data = Cow::Borrowed(guide.data.as_slice());
            if settings.prefilter == Prefilter::Accurate {
                let mut out = vec![0.0; data.len()];
                let image = Image {
                    data: &data,
                    channels,
                };
                guided.filter(&[(*role, image)], &mut out, channels, false)?;
                data = Cow::Owned(out);
            }
            guides.push(Guide {
                role: *role,
                data,
                channels,
            });
        }
        guided.guides = guides;
        Ok(guided)
    }

    /// Denoises light; its fourth channel stays.
    pub(super) fn light(
        &self,
        noisy: &[f32],
        channels: usize,
        albedo: Albedo,
    ) -> Result<Vec<f32>, DenoiseError> {
        let pixels = noisy.len() / channels.max(1);
        let grey = || self.grey.get_or_init(|| vec![GREY; 3 * pixels]);
        let light = Image {
            data: noisy,
            channels,
        };
        let mut images = vec![(Role::Color, light)];
        images.extend(self.guides.iter().map(|guide| {
            let says_nothing = guide.role == Role::Albedo && albedo == Albedo::IsNotInIt;
            let (data, channels) = if says_nothing {
                (grey().as_slice(), 3)
            } else {
                (&*guide.data, guide.channels)
            };
            (guide.role, Image { data, channels })
        }));
        let mut out = noisy.to_vec();
        self.filter(&images, &mut out, channels, true)?;
        Ok(out)
    }

    fn filter(
        &self,
        images: &[(Role, Image)],
        out: &mut [f32],
        channels: usize,
        hdr: bool,
    ) -> Result<(), DenoiseError> {
        let filter = Filter {
            hdr,
            clean_guides: self.settings.prefilter != Prefilter::Fast,
            quality: self.settings.quality,
        };
        let out = (out, channels);
        let run = self
            .device
            .run(self.size, images, out, filter, self.cancelled);
        run.map_err(DenoiseError::from)
    }
}
