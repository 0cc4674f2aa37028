//! Visibility sources in shaders.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::slots::{First, Second};
use super::{PointSlot, VisibilitySlot};
use crate::visibility::{Both, Unshadowed};

impl InShader<VisibilitySlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl InShader<PointSlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed_point.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

/// The two must be of different kinds: two marches do not meet in one shader.
impl<A, B> InShader<VisibilitySlot> for Both<A, B>
where
    A: InShader<VisibilitySlot>,
    B: InShader<VisibilitySlot>,
{
    fn part() -> Part {
        let (first, second) = (A::part(), B::part());
        Part::new("light_both")
            .glue::<First>(&first)
            .glue::<Second>(&second)
            .with(first)
            .with(second)
            .source(include_str!("both.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        [self.0.constants(), self.1.constants()].concat()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.0.arguments();
        arguments.extend(self.1.arguments());
        arguments
    }
}

#[cfg(feature = "shadow-map")]
mod march {
    use bytemuck::{Pod, Zeroable};
    use gpu_backend::gpu::{Argument, GpuMemory, InShader};
    use gpu_backend::shader::Part;

    use crate::gpu::scene::PicturesRecord;
    use crate::gpu::{FACE, MAP, PLACE, PointSlot, VisibilitySlot};
    use crate::shadow_map::ShadowMap;
    use crate::visibility::{March, Spacing};

    /// `light_March` of `march.wgsl`.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, Pod, Zeroable)]
    pub(in crate::gpu) struct MarchRecord {
        pub(in crate::gpu) steps: u32,
        pub(in crate::gpu) equi_angular: u32,
    }

    impl<P: InShader<PointSlot>> InShader<VisibilitySlot> for March<P> {
        fn part() -> Part {
            let points = P::part();
            Part::new("light_march")
                .glue::<PointSlot>(&points)
                .with(points)
                .uniform("light_march", "light_March")
                .source(include_str!("march.wgsl"))
        }

        fn constants(&self) -> Vec<(&'static str, f64)> {
            self.points().constants()
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            let mut arguments = self.points().arguments();
            arguments.push(Argument::uniform(MarchRecord {
                steps: self.steps(),
                equi_angular: u32::from(self.spacing() == Spacing::EquiAngular),
            }));
            arguments
        }
    }

    /// The text and the variables of a shadow map.
    pub(in crate::gpu) fn map_part() -> Part {
        Part::new("light_map")
            .sources(&[FACE, PLACE, MAP])
            .uniform("light_map", "light_Pictures")
            .read("light_map_depths", "array<f32>")
    }

    pub(in crate::gpu) fn map_arguments(map: &ShadowMap<GpuMemory>) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(PicturesRecord::new(map.faces(), map.resolution())),
            Argument::read(map.depth()),
        ]
    }

    impl InShader<PointSlot> for ShadowMap<GpuMemory> {
        fn part() -> Part {
            map_part()
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            map_arguments(self)
        }
    }
}

#[cfg(all(feature = "shadow-map", test))]
pub(super) use march::MarchRecord;
#[cfg(feature = "voxel-shadow")]
pub(super) use march::{map_arguments, map_part};

#[cfg(feature = "translucent")]
mod translucent {
    use gpu_backend::gpu::{Argument, GpuMemory, InShader};
    use gpu_backend::shader::Part;
    use transmittance::gpu::lookup_parts;
    use transmittance::{Filter, Packed};

    use crate::gpu::scene::PicturesRecord;
    use crate::gpu::{FACE, PLACE, PointSlot, TRANSMITTANCE_MAP};
    use crate::translucent::TransmittanceMap;

    impl InShader<PointSlot> for TransmittanceMap<GpuMemory> {
        fn part() -> Part {
            Part::new("light_curves")
                .sources(&[FACE, PLACE])
                .sources(&lookup_parts::<Packed<8>, 1>())
                .source(TRANSMITTANCE_MAP)
                .uniform("light_curves", "light_Pictures")
                .read("light_curve_words", "array<u32>")
        }

        fn constants(&self) -> Vec<(&'static str, f64)> {
            let is_bilinear = self.filter() == Filter::Bilinear;
            vec![
                ("BILINEAR", f64::from(u8::from(is_bilinear))),
                ("FACE_WORDS", f64::from(self.face_words())),
            ]
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            vec![
                Argument::uniform(PicturesRecord::new(self.faces(), self.resolution())),
                Argument::read(self.curves()),
            ]
        }
    }
}
