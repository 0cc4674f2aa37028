//! Gathers through heterogeneous media in the list of methods: one for each kind of map that
//! gives the visibility of the light.

use std::any::TypeId;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use transmittance::baseline::{
    Deep, DeepCurve, FourierCurve, MomentCurve, Moments, OpacityCurve, Range,
};
use transmittance::{Accumulate, Curve, Evaluate, Linear, Packed, Stream};

use super::exact_triangles::{EIGHT_NODES, SIXTEEN_NODES};
#[cfg(feature = "wgpu")]
use super::method_gpu::CurvesInShaders as CurvesEverywhere;
use super::{DoubleMarch, GatherMedia, MediaRays};
use crate::methods::translucent::{Casters, TransmittanceMap};
use crate::methods::{
    About, Entry, Frame, FrameInputs, Method, MethodError, Role, RunOn, Store, Verdict, Work,
};
use crate::scene::{Bounds, Emitter, Translucent};
use crate::shadow_map::{ShadowMap, faces, locate};
use crate::visibility::PointVisibility;

/// Makes the map of a light.
type Make = fn(&FrameInputs<'_>, usize) -> Result<Map, MethodError>;

/// The visibility past translucent casters.
type Map = Arc<dyn PointVisibility<Share = Vec3> + Send>;

/// A kind of maps, which the store of the host keeps.
pub(super) trait Curves: Send + Sync + 'static {
    /// Whether there are maps. Without, only opaque casters cast shadows.
    const IS_THERE: bool = true;

    /// The map of a light, without opaque casters.
    fn map(&self, inputs: &FrameInputs<'_>, light: usize) -> Result<Option<Map>, MethodError>;
}

/// Maps that shaders can read too, in builds with shaders.
#[cfg(not(feature = "wgpu"))]
trait CurvesEverywhere: Curves {}

#[cfg(not(feature = "wgpu"))]
impl<C: Curves> CurvesEverywhere for C {}

/// No maps.
pub(super) struct NoCurves;

impl Curves for NoCurves {
    const IS_THERE: bool = false;

    fn map(&self, _: &FrameInputs<'_>, _: usize) -> Result<Option<Map>, MethodError> {
        Ok(None)
    }
}

/// Curves of a fixed size, made as `A` and looked up as `T`.
pub(super) struct OfSize<A, T>(PhantomData<fn() -> (A, T)>);

/// Curves by the paper's rule.
type ByRule<const N: usize> = OfSize<Curve<N, Linear>, Packed<N, Linear>>;

/// Curves by least area.
pub(super) type ByArea<const N: usize> = OfSize<Stream<N>, Packed<N>>;

impl<A, T> Default for OfSize<A, T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<A, T> OfSize<A, T>
where
    A: Accumulate + Default + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + fmt::Debug + Send + Sync + 'static,
{
    /// The map of a light.
    pub(super) fn on_host(
        inputs: &FrameInputs<'_>,
        light: usize,
        panes: Panes,
    ) -> Result<Arc<TransmittanceMap<Host, T>>, MethodError> {
        map_of(inputs, light, panes, &A::default())
    }
}

impl<A, T> Curves for OfSize<A, T>
where
    A: Accumulate + Default + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + fmt::Debug + Send + Sync + 'static,
{
    fn map(&self, inputs: &FrameInputs<'_>, light: usize) -> Result<Option<Map>, MethodError> {
        Ok(Some(Self::on_host(inputs, light, Panes::InMap)?))
    }
}

/// Maps of another kind, on the CPU alone.
struct OnHost(Make);

impl Curves for OnHost {
    fn map(&self, inputs: &FrameInputs<'_>, light: usize) -> Result<Option<Map>, MethodError> {
        self.0(inputs, light).map(Some)
    }
}

/// A gather with maps of one kind.
pub(super) struct Gathered<C> {
    about: Named,
    curves: C,
    /// Bytes of a curve.
    bytes: u64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Named {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) purpose: &'static str,
    pub(super) paper: &'static str,
    pub(super) role: Role,
    pub(super) quick: &'static [u32],
}

impl<C> fmt::Debug for Gathered<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.about.fmt(f)
    }
}

/// The largest number of steps for a ray.
const MAX_STEPS: u32 = 1 << 16;

const QUALITIES: &[u32] = &[8, 16, 32, 64, 128];

pub(super) fn about(named: Named, unit: &'static str) -> About {
    About {
        name: named.name.into(),
        title: named.title,
        purpose: named.purpose,
        paper: named.paper,
        quality: unit,
        qualities: QUALITIES,
        quick: named.quick,
        pictured: 64,
        usual: 256,
        role: named.role,
        uses_shadow_map: true,
    }
}

pub(super) fn check(steps: u32, unit: &'static str) -> Result<(), MethodError> {
    if (1..=MAX_STEPS).contains(&steps) {
        return Ok(());
    }
    Err(MethodError::Quality {
        value: steps,
        unit,
        expected: format!("1 to {MAX_STEPS}"),
    })
}

pub(super) fn needs_media(inputs: &FrameInputs<'_>) -> Verdict {
    match inputs.media().is_homogeneous() {
        true => Verdict::Pointless("the medium is the same everywhere".into()),
        false => Verdict::Applies,
    }
}

fn has_hair(inputs: &FrameInputs<'_>) -> bool {
    let is_hair = |caster: &Translucent| matches!(caster, Translucent::Strands(_));
    inputs.translucent.iter().any(is_hair)
}

pub(super) const STEPS: &str = "steps";

impl<C: Curves> Method for Gathered<C> {
    fn about(&self) -> About {
        about(self.about, STEPS)
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        needs_media(inputs)
    }

    fn sees_heterogeneous_media(&self) -> bool {
        true
    }

    fn sees_cover(&self) -> bool {
        true
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        if !C::IS_THERE && has_hair(inputs) {
            notes.push("hair casts no shadow into the air".into());
        }
        if !C::IS_THERE && inputs.geometry.coatings().any_see_through() {
            notes.push(format!(
                "see-through surfaces cast no shadow into the air with {}",
                self.about.name
            ));
        }
        if !C::IS_THERE {
            notes.push("smoke casts no shadows".into());
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let maps = inputs.map_work();
        let curves = bytes_of_curves(inputs, Panes::InMap, self.bytes);
        Work {
            // The work of a curve is the number of its values.
            once: maps.once + (curves / 4) as f64,
            bytes: maps.bytes + curves,
            per_ray: inputs.emitters.len() as f64 * 4.0 * f64::from(steps),
            ..maps
        }
    }
}

/// The memory of the maps of all lights, with curves of `each` bytes.
pub(super) fn bytes_of_curves(inputs: &FrameInputs<'_>, panes: Panes, each: u64) -> u64 {
    let casters = casters(inputs, panes);
    let texels = inputs.emitters.iter().map(|emitter| {
        let side = casters.resolution(inputs.map, inputs.emitters, emitter);
        casters.texels(emitter, side)
    });
    texels.sum::<u64>() * casters.channels() as u64 * each
}

/// The visibility past opaque and translucent casters.
struct Both {
    opaque: Arc<ShadowMap<Host>>,
    translucent: Option<Map>,
}

impl PointVisibility for Both {
    type Share = Vec3;

    fn visibility(&self, point: Vec3) -> Vec3 {
        match (self.opaque.visibility(point), &self.translucent) {
            (0.0, _) => Vec3::ZERO,
            (share, None) => Vec3::splat(share),
            (share, Some(map)) => share * map.visibility(point),
        }
    }
}

impl<C: Curves> Gathered<C> {
    fn visibility(&self, frame: &Frame<'_, Cpu>, light: usize) -> Result<Both, MethodError> {
        Ok(Both {
            opaque: frame.shadow_map(light)?,
            translucent: self.curves.map(&frame.inputs, light)?,
        })
    }
}

impl<C> Gathered<C> {
    pub(super) fn check(steps: u32) -> Result<(), MethodError> {
        check(steps, STEPS)
    }
}

impl<C: Curves> RunOn<Cpu> for Gathered<C> {
    fn prepare(&self, frame: &Frame<'_, Cpu>, steps: u32) -> Result<(), MethodError> {
        Self::check(steps)?;
        (0..frame.inputs.emitters.len()).try_for_each(|light| {
            frame.inputs.go_on(light)?;
            self.visibility(frame, light).map(|_| ())
        })
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        steps: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        Self::check(steps)?;
        gather_lights(frame, steps, radiance, |light| {
            self.visibility(frame, light)
        })
    }
}

/// Gathers the light of all lamps of a frame, each with its own visibility.
pub(super) fn gather_lights<V>(
    frame: &Frame<'_, Cpu>,
    steps: u32,
    radiance: &mut Vec<[f32; 4]>,
    visibility: impl Fn(usize) -> Result<V, MethodError>,
) -> Result<(), MethodError>
where
    Cpu: GatherMedia<V>,
{
    let inputs = &frame.inputs;
    let media = inputs.media();
    let panes = inputs.panes()?;
    for (light, emitter) in inputs.emitters.iter().enumerate() {
        inputs.go_on(light)?;
        let visibility = visibility(light)?;
        let lit = MediaRays {
            rays: &frame.rays,
            emitter,
            media: &media,
            steps,
            panes: panes.as_ref(),
            watch: inputs.watch,
        };
        frame.pass("gather through media", || {
            Ok(frame.backend.gather_media(&lit, &visibility, radiance)?)
        })?;
    }
    Ok(())
}

/// The double march.
#[derive(Debug, Clone, Copy)]
struct BruteForce;

/// The unit of its quality.
const BOTH_STEPS: &str = "steps along the ray and to the light";

impl Method for BruteForce {
    fn about(&self) -> About {
        let named = Named {
            name: "media-double-march",
            title: "marching twice",
            purpose: "what every renderer of smoke begins with: from each step a march to the light",
            paper: "Blinn, SIGGRAPH 1982, for the integral; Kajiya and Von Herzen, SIGGRAPH 1984",
            role: Role::Baseline,
            quick: &[16],
        };
        about(named, BOTH_STEPS)
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        needs_media(inputs)
    }

    fn sees_heterogeneous_media(&self) -> bool {
        true
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        if has_hair(inputs) {
            notes.push("hair casts no shadow into the air".into());
        }
        if inputs.geometry.coatings().any_see_through() {
            notes.push(format!(
                "see-through surfaces neither shade the air nor dim what is behind them with {}",
                self.about().name
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps).powi(2),
            ..inputs.map_work()
        }
    }
}

impl RunOn<Cpu> for BruteForce {
    fn prepare(&self, frame: &Frame<'_, Cpu>, steps: u32) -> Result<(), MethodError> {
        check(steps, BOTH_STEPS)?;
        (0..frame.inputs.emitters.len()).try_for_each(|light| {
            frame.inputs.go_on(light)?;
            frame.shadow_map(light).map(|_| ())
        })
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        steps: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        check(steps, BOTH_STEPS)?;
        let inputs = &frame.inputs;
        let media = inputs.media();
        for (light, emitter) in inputs.emitters.iter().enumerate() {
            inputs.go_on(light)?;
            let map = frame.shadow_map(light)?;
            let march = DoubleMarch::new(emitter, &media, inputs.translucent, map, [steps; 2]);
            frame.pass("marches", || {
                frame.backend.for_each_chunk(radiance, 16, |first, chunk| {
                    for (sum, ray) in chunk.iter_mut().zip(&frame.rays[first..]) {
                        let light = march.radiance(ray);
                        for (sum, light) in sum.iter_mut().zip(light.to_array()) {
                            *sum += light;
                        }
                    }
                    inputs.watch.gathered(chunk.len());
                });
                Ok(())
            })?;
        }
        Ok(())
    }
}

/// Where the shadows of see-through triangles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Panes {
    /// In the map of transmittance.
    InMap,
    /// Elsewhere.
    Apart,
}

/// The casters of a map of transmittance.
pub(super) fn casters<'a>(inputs: &FrameInputs<'a>, panes: Panes) -> Casters<'a> {
    match panes {
        Panes::InMap => Casters::see_through(inputs.translucent, inputs.geometry),
        Panes::Apart => Casters::new(inputs.translucent, None),
    }
}

/// The key of a transmittance map: what makes its curves, its light, texels per side, and where
/// see-through triangles are.
type Key = (TypeId, usize, u32, Panes);

pub(super) fn key<A: 'static>(inputs: &FrameInputs<'_>, light: usize, panes: Panes) -> Key {
    let emitter = &inputs.emitters[light];
    let resolution = casters(inputs, panes).resolution(inputs.map, inputs.emitters, emitter);
    // Where there are none, the maps are the same.
    let panes = match inputs.geometry.coatings().any_see_through() {
        true => panes,
        false => Panes::InMap,
    };
    (TypeId::of::<A>(), light, resolution, panes)
}

/// Puts the map of a light that was made elsewhere into a store, for gathers with curves of
/// eight nodes by least area. It must be that of all translucent casters and see-through
/// triangles, and is not used by gathers that need more [texels](Casters::resolution).
pub fn share_transmittance_map(host: &Store<Host>, light: usize, map: &Arc<TransmittanceMap>) {
    let key: Key = (
        TypeId::of::<Stream<8>>(),
        light,
        map.resolution(),
        Panes::InMap,
    );
    host.insert("map of transmittance", key, map.clone(), map.bytes());
}

/// The map of a light, in the store of the host, without opaque casters.
fn map_of<A, T>(
    inputs: &FrameInputs<'_>,
    light: usize,
    panes: Panes,
    clear: &A,
) -> Result<Arc<TransmittanceMap<Host, T>>, MethodError>
where
    A: Accumulate + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + fmt::Debug + Send + Sync + 'static,
{
    let casters = casters(inputs, panes);
    let key = key::<A>(inputs, light, panes);
    inputs
        .host
        .get("map of transmittance", key, TransmittanceMap::bytes, || {
            let emitter = &inputs.emitters[light];
            TransmittanceMap::build_as_needed(&Cpu::new(), &casters, emitter, key.2, clear)
                .map_err(MethodError::resource("a map of transmittance"))
        })
}

/// The same, whatever it holds.
fn map<A, T>(inputs: &FrameInputs<'_>, light: usize, clear: &A) -> Result<Map, MethodError>
where
    A: Accumulate + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + fmt::Debug + Send + Sync + 'static,
{
    Ok(map_of::<A, T>(inputs, light, Panes::InMap, clear)?)
}

fn deep(inputs: &FrameInputs<'_>, light: usize) -> Result<Map, MethodError> {
    let clear = Deep::new(0.002).map_err(MethodError::resource("a deep shadow map"))?;
    map::<_, DeepCurve>(inputs, light, &clear)
}

/// Curves for the range of depths that translucent casters have as seen from a light.
fn in_range<A, T>(
    inputs: &FrameInputs<'_>,
    light: usize,
    clear: impl FnOnce(Range) -> Result<A, transmittance::Error>,
) -> Result<Map, MethodError>
where
    A: Accumulate + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + fmt::Debug + Send + Sync + 'static,
{
    let casters = Casters::see_through(inputs.translucent, inputs.geometry);
    let [near, far] = casters
        .bounds()
        .map_or([0.0, 1.0], |bounds| depths(bounds, &inputs.emitters[light]));
    let clear = Range::new(near, far).and_then(clear);
    map::<_, T>(
        inputs,
        light,
        &clear.map_err(MethodError::resource("a range of depths"))?,
    )
}

/// The range of depths of a box as seen from a light.
fn depths(bounds: Bounds, emitter: &Emitter) -> [f32; 2] {
    let [near, far] = match emitter {
        Emitter::Directional(_) => {
            // In the map's own depths, which begin at a plane in front of the box.
            let planes = faces(bounds, emitter);
            let centre = 0.5 * (bounds.min() + bounds.max());
            let half = 0.5 * (bounds.max() - bounds.min()).length();
            let middle = locate(&planes, 1, centre).map_or(half, |place| place.depth);
            [middle - half, middle + half]
        }
        Emitter::Point(point) => {
            let light = point.position();
            let nearest = light.clamp(bounds.min(), bounds.max());
            let far = (bounds.corners().iter())
                .map(|corner| corner.distance(light))
                .fold(0.0, f32::max);
            [nearest.distance(light), far]
        }
    };
    [near, far.max(near.next_up())]
}

fn opacity(inputs: &FrameInputs<'_>, light: usize) -> Result<Map, MethodError> {
    in_range::<_, OpacityCurve<32>>(inputs, light, |range| Ok(OpacityCurve::<32>::new(range)))
}

fn fourier(inputs: &FrameInputs<'_>, light: usize) -> Result<Map, MethodError> {
    in_range::<_, FourierCurve<16>>(inputs, light, |range| Ok(FourierCurve::<16>::new(range)))
}

fn moments(inputs: &FrameInputs<'_>, light: usize) -> Result<Map, MethodError> {
    in_range::<_, MomentCurve>(inputs, light, |range| Moments::new(6, range))
}

/// A method with maps that shaders can read.
fn everywhere<C: CurvesEverywhere>(about: Named, curves: C, nodes: u64) -> Entry {
    Entry::everywhere(Gathered {
        about,
        curves,
        bytes: 8 * nodes,
    })
}

/// One with others.
fn on_host(about: Named, make: Make, bytes: u64) -> Entry {
    let curves = OnHost(make);
    Entry::on_cpu(Gathered {
        about,
        curves,
        bytes,
    })
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let rule = |name, title| Named {
        name,
        title,
        purpose: "smoke that is seen and shades itself: curves by the paper's rule",
        paper: "Salvi et al., Adaptive Volumetric Shadow Maps, EGSR 2010",
        role: Role::Paper,
        quick: &[16],
    };
    let area = Named {
        name: "media-area-8",
        title: "AVSM by least area, 8 nodes",
        purpose: "smoke that is seen and shades itself, from curves of the least mean error",
        paper: "Salvi et al., EGSR 2010; nodes by least area instead of theirs",
        role: Role::Paper,
        quick: &[16, 64],
    };
    let variant = |name, title, purpose, paper| Named {
        name,
        title,
        purpose,
        paper,
        role: Role::Variant,
        quick: &[16],
    };
    let unshadowed = Named {
        name: "media-unshadowed",
        title: "smoke without shadows of smoke",
        purpose: "smoke that is seen and casts no shadow: what its shadows are worth",
        paper: "none: shadow maps of what is opaque",
        role: Role::Unshadowed,
        quick: &[32],
    };
    vec![
        Entry::everywhere(EIGHT_NODES),
        Entry::everywhere(SIXTEEN_NODES),
        everywhere(area, ByArea::<8>::default(), 8),
        everywhere(unshadowed, NoCurves, 0),
        everywhere(
            rule("media-avsm-4", "AVSM, 4 nodes"),
            ByRule::<4>::default(),
            4,
        ),
        everywhere(
            rule("media-avsm-8", "AVSM, 8 nodes"),
            ByRule::<8>::default(),
            8,
        ),
        everywhere(
            rule("media-avsm-12", "AVSM, 12 nodes"),
            ByRule::<12>::default(),
            12,
        ),
        everywhere(
            rule("media-avsm-16", "AVSM, 16 nodes"),
            ByRule::<16>::default(),
            16,
        ),
        everywhere(
            Named {
                name: "media-area-16",
                title: "AVSM by least area, 16 nodes",
                purpose: "smoke that is seen and shades itself, curves of the least mean error \
                          with 16 nodes",
                role: Role::Variant,
                quick: &[16],
                ..area
            },
            ByArea::<16>::default(),
            16,
        ),
        on_host(
            variant(
                "media-deep",
                "deep shadow maps",
                "curves as long as an error of 0.002 takes",
                "Lokovic and Veach, Deep Shadow Maps, SIGGRAPH 2000",
            ),
            deep,
            128,
        ),
        on_host(
            variant(
                "media-opacity-32",
                "opacity shadow maps",
                "32 slices between the nearest and the farthest smoke",
                "Kim and Neumann, Opacity Shadow Maps, EGWR 2001",
            ),
            opacity,
            128,
        ),
        on_host(
            variant(
                "media-fourier-16",
                "Fourier opacity maps",
                "16 pairs of coefficients between the nearest and the farthest smoke",
                "Jansen and Bavoil, Fourier Opacity Mapping, I3D 2010",
            ),
            fourier,
            128,
        ),
        on_host(
            variant(
                "media-moments-6",
                "moments of optical depth",
                "6 moments between the nearest and the farthest smoke",
                "Münstermann et al., Moment-Based Order-Independent Transparency, I3D 2018",
            ),
            moments,
            28,
        ),
        Entry::on_cpu(BruteForce),
    ]
}
