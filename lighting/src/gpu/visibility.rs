//! Visibility sources with a shader part.

use gpu_backend::gpu::Argument;

use crate::visibility::{MergeTouching, Unshadowed};

/// A visibility source that brings its part of a shader.
pub trait WgslVisibility {
    /// WGSL that defines `light_Look`, `light_look` and `light_next_lit`; see
    /// [`LIT`](super::LIT) for what they must do. Its bindings are in
    /// `@group(1)`.
    fn parts() -> &'static [&'static str];

    /// Values of `override` constants.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// What is bound to `@group(1)`.
    fn arguments(&self) -> Vec<Argument<'_>>;
}

impl WgslVisibility for Unshadowed {
    fn parts() -> &'static [&'static str] {
        &[include_str!("unshadowed.wgsl")]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

/// The entry point joins the parts.
impl<V: WgslVisibility> WgslVisibility for MergeTouching<V> {
    fn parts() -> &'static [&'static str] {
        V::parts()
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        let mut constants = self.0.constants();
        if constants.iter().all(|(name, _)| *name != "MERGE") {
            constants.push(("MERGE", 1.0));
        }
        constants
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        self.0.arguments()
    }
}

#[cfg(feature = "shadow-map")]
mod march {
    use gpu_backend::gpu::{Argument, GpuMemory};

    use super::WgslVisibility;
    use crate::gpu::scene::Map;
    use crate::visibility::ShadowMapMarch;

    impl WgslVisibility for ShadowMapMarch<'_, GpuMemory> {
        fn parts() -> &'static [&'static str] {
            &[
                crate::gpu::FACE,
                crate::gpu::PLACE,
                crate::gpu::MAP,
                include_str!("map_faces.wgsl"),
                include_str!("map_bindings.wgsl"),
                include_str!("lit_march.wgsl"),
                include_str!("march.wgsl"),
                include_str!("march_bindings.wgsl"),
            ]
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            vec![
                Argument::uniform(Map::of_march(self)),
                Argument::read(self.map().depth()),
            ]
        }
    }
}

#[cfg(feature = "translucent")]
mod translucent {
    use gpu_backend::gpu::{Argument, GpuMemory};
    use transmittance::gpu::lookup_parts;
    use transmittance::{Filter, Packed};

    use super::WgslVisibility;
    use crate::gpu::scene::Map;
    use crate::translucent::StoredMap;
    use crate::visibility::TransmittanceMarch;

    impl WgslVisibility for TransmittanceMarch<'_, StoredMap<GpuMemory>> {
        fn parts() -> &'static [&'static str] {
            const LOOKUP: [&str; 7] = lookup_parts::<Packed<8>, 1>();
            &[
                crate::gpu::FACE,
                crate::gpu::PLACE,
                include_str!("map_faces.wgsl"),
                LOOKUP[0],
                LOOKUP[1],
                LOOKUP[2],
                LOOKUP[3],
                LOOKUP[4],
                LOOKUP[5],
                crate::gpu::VEIL,
                include_str!("veil_bindings.wgsl"),
                include_str!("march.wgsl"),
                include_str!("march_bindings.wgsl"),
            ]
        }

        fn constants(&self) -> Vec<(&'static str, f64)> {
            let is_bilinear = self.map().filter() == Filter::Bilinear;
            vec![
                ("BILINEAR", f64::from(u8::from(is_bilinear))),
                ("FACE_WORDS", f64::from(self.map().face_words())),
            ]
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            vec![
                Argument::uniform(Map::of_transmittance_march(self)),
                Argument::read(self.map().words()),
            ]
        }
    }
}
