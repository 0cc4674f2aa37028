//! The parts of a plan: passes, and what is left out.

/// A pass that will run.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pass {
    /// The airlight of these emitters, by any pair of visibility and evaluator.
    Airlight {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// The airlight of these emitters in closed form, because nothing blocks them.
    Unshadowed {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// One shadow map for each of these emitters, for methods that look into shadow maps.
    ShadowMaps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// For precomputed methods: shadows of all that stays, made once for all frames.
    Bakes {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// For precomputed methods: shadow maps of the [dynamic] casters alone, made anew when
    /// these have moved.
    ///
    /// [dynamic]: crate::scene::Geometry::dynamic_part
    DynamicMaps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// Steps of equal angle at these emitters, for equi-angular methods.
    EquiAngularSteps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
}

/// Something that will not run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// What would have run.
    pub subject: Subject,
    /// Why it is not needed.
    pub reason: Reason,
    /// What leaving it out saves.
    pub saving: Saving,
}

/// Work that is saved, in counts that do not depend on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Saving {
    /// Rays whose airlight or lit parts are not computed, once for each emitter.
    pub rays: u64,
    /// Texels that are not made.
    pub texels: u64,
    /// Memory that is not taken, bytes.
    pub bytes: u64,
}

impl Saving {
    /// Nothing is saved.
    pub const NOTHING: Self = Self {
        rays: 0,
        texels: 0,
        bytes: 0,
    };
}

/// What can be left out.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Subject {
    /// All airlight: no emitter is gathered.
    Airlight,
    /// The airlight of these emitters, and their shadow maps.
    Emitters(Vec<usize>),
    /// The shadows of these emitters in the air, and their shadow maps.
    Shadows(Vec<usize>),
    /// For precomputed methods, shadow maps of the dynamic casters for these emitters.
    DynamicMaps(Vec<usize>),
    /// Steps of equal angle.
    EquiAngularSteps,
    /// Lists of the lights of each tile of the picture.
    LightLists,
    /// One atlas of the maps and the voxels of many points.
    Atlas,
    /// The colours of cookies.
    Cookies,
    /// Transmittance curves for each texel of a light's map.
    Curves,
    /// The dimming of the air behind glass and hair.
    Panes,
}

/// Why something is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Vacuum scatters nothing.
    NoMedium,
    /// The medium absorbs but does not scatter.
    NothingScattered,
    /// The scene has no light.
    NoLight,
    /// The light emits nothing.
    Dark,
    /// No ray of the view meets the medium within the light's range and cone.
    NeverMeetsTheView,
    /// No caster is between the light and the air that the view shows.
    NothingInTheWay,
    /// No caster is marked as dynamic.
    NothingMoves,
    /// The light shines on no dynamic caster.
    ReachesNothingDynamic,
    /// Directional light comes from the same direction everywhere.
    OnlyDirectionalLight,
    /// Too few lights have a range or a cone for [culling](crate::culling::is_worthwhile).
    FewBoundedLights,
    /// No light is an area light.
    NoArea,
    /// No light has a cookie.
    NoCookie,
    /// There is no hair, no smoke and no see-through surface.
    NothingTranslucent,
    /// No see-through surface and no hair is in front of any air.
    NothingCoversTheAir,
}
