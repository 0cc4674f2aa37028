//! The parts of a picture, as channels of an EXR file.

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use glam::Vec3;

use super::Shot;
use crate::failure::Failure;
use crate::format::{bytes, count};
use crate::input::Input;
use crate::parse::Size;
use crate::picture::Picture;

/// Channels take at most this much memory: 4 GiB.
const MAX_BYTES: u64 = 1 << 32;

/// The picture, its surfaces, its fog, the light that either emits, the indirect light, and the
/// transmittance.
const OF_ALL_LIGHTS: u64 = 7;

/// Surfaces and fog.
const OF_EACH_LIGHT: u64 = 2;

/// Refuses a picture whose layers do not fit into memory.
pub(super) fn check(size: Size, lights: usize) -> Result<(), Failure> {
    let layers = OF_ALL_LIGHTS + OF_EACH_LIGHT * lights as u64;
    let needed = layers * 12 * size.pixels() as u64;
    if needed <= MAX_BYTES {
        return Ok(());
    }
    Err(Failure::new(format!(
        "--layers: {layers} layers of {size} pixels, for {}, take {}, at most {} are supported",
        count(lights, "light"),
        bytes(needed),
        bytes(MAX_BYTES)
    )))
}

/// A picture and its parts.
pub(super) struct Layers {
    pub(super) picture: Picture,
    /// By the beginning of the channel's name.
    parts: Vec<(String, Picture)>,
}

impl Layers {
    pub(super) fn of(shot: &Shot<'_>, input: &mut Input) -> Result<Self, Failure> {
        let black = Picture::black(shot.args.size);
        let emitted = shot.surfaces(input, &[])?;
        // Each light alone lights surfaces that do not glow.
        let materials = &mut input.scene.materials;
        let glow: Vec<Vec3> = materials
            .iter_mut()
            .map(|m| std::mem::take(&mut m.emitted))
            .collect();
        let (mut surfaces, mut fog) = (emitted.clone(), black.clone());
        let mut parts = vec![("emitted".into(), emitted)];
        for light in 0..input.scene.lights.len() {
            let emitters: Vec<usize> = input.of_light[light].clone().collect();
            let own = shot.surfaces(input, &emitters)?;
            let kept: Vec<usize> = emitters
                .into_iter()
                .filter(|index| shot.kept.contains(index))
                .collect();
            let airlight = shot
                .airlight(input, &kept)?
                .unwrap_or_else(|| black.clone());
            surfaces = surfaces.plus(&own);
            fog = fog.plus(&airlight);
            let name = layer_name(light, input.scene.lights[light].name());
            parts.push((format!("{name}.surfaces"), own));
            parts.push((format!("{name}.fog"), airlight));
        }
        for (material, glow) in input.scene.materials.iter_mut().zip(glow) {
            material.emitted = glow;
        }
        if let Some(indirect) = shot.indirect(input)? {
            surfaces = surfaces.plus(&indirect);
            parts.push(("indirect".into(), indirect));
        }
        if let Some(emission) = shot.emission(input)? {
            fog = fog.plus(&emission);
            parts.push(("fog.emitted".into(), emission));
        }
        let picture = surfaces.plus(&fog);
        parts.push(("surfaces".into(), surfaces));
        parts.push(("fog".into(), fog));
        parts.push(("transmittance".into(), transmittance(shot, input)));
        Ok(Self { picture, parts })
    }

    /// The file.
    pub(super) fn exr(self) -> Result<Vec<u8>, Failure> {
        let size = self.picture.size;
        let mut channels = Vec::new();
        let parts = self.parts.into_iter();
        let parts = parts.map(|(name, picture)| (format!("{name}."), picture));
        for (prefix, picture) in parts.chain([(String::new(), self.picture)]) {
            for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
                let samples = picture.pixels.iter().map(|pixel| pixel[channel]).collect();
                let name = format!("{prefix}{name}");
                channels.push(AnyChannel::new(name.as_str(), FlatSamples::F32(samples)));
            }
        }
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let size = (size.width as usize, size.height as usize);
        let mut file = std::io::Cursor::new(Vec::new());
        Image::from_channels(size, channels)
            .write()
            .to_buffered(&mut file)?;
        Ok(file.into_inner())
    }
}

/// `light.0`, or `light.0-sun` of a light called "sun". Programs take dots for levels of
/// names and know ASCII alone.
fn layer_name(light: usize, name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().take(32).map(plain).collect();
    match name.as_str() {
        "" => format!("light.{light}"),
        name => format!("light.{light}-{name}"),
    }
}

/// The share of light that the fog in front of the surface of a pixel lets through.
fn transmittance(shot: &Shot<'_>, input: &Input) -> Picture {
    let media = input.media();
    let through = |ray: &lighting::Ray| {
        let share = match &shot.medium {
            _ if !media.is_homogeneous() => media.transmittance(ray, ray.length()),
            None => Vec3::ONE,
            // 0 · ∞: a medium that extinguishes nothing does so over any length.
            Some(medium) if medium.sigma_t() == Vec3::ZERO => Vec3::ONE,
            Some(medium) => {
                let length = medium.length_inside(ray.origin(), ray.direction(), ray.length());
                (-medium.sigma_t() * length).exp()
            }
        };
        [share.x, share.y, share.z, 0.0]
    };
    let shares: Vec<[f32; 4]> = shot.view.rays().iter().map(through).collect();
    shot.pixels(&shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_have_names_that_every_program_reads() {
        assert_eq!(layer_name(3, ""), "light.3");
        assert_eq!(layer_name(0, "Key Licht.ä"), "light.0-Key_Licht__");
        assert!(layer_name(0, &"x".repeat(999)).len() < 60);
    }

    #[test]
    fn layers_that_fit_into_no_memory_are_refused() {
        let size = Size {
            width: 960,
            height: 540,
        };
        assert!(check(size, 165).is_ok());
        let error = check(size, 1000).unwrap_err().to_string();
        assert!(error.contains("1000 lights"), "{error}");
    }
}
