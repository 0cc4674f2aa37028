//! What a plan consists of.

/// A pass that will run.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pass {
    /// The airlight of these emitters, by any pair of visibility and evaluator.
    Airlight {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// The airlight of these emitters in closed form: nothing is in their way.
    Unshadowed {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// For methods that look into shadow maps: one map each.
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
    /// For equi-angular methods: steps of equal angle at these emitters.
    EquiAngularSteps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
}

/// A pass that will not run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// What would have run.
    pub subject: Subject,
    /// Why it need not.
    pub reason: Reason,
    /// What that saves.
    pub saving: Saving,
}

/// Work that is not done, counted, so that it does not depend on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Saving {
    /// Rays, once for each emitter, whose airlight or whose lit parts are not asked for.
    pub rays: u64,
    /// Texels that are not made.
    pub texels: u64,
    /// Memory that is not taken, bytes.
    pub bytes: u64,
}

impl Saving {
    /// None.
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
    /// Curves of transmittance for each texel of a light's map.
    Curves,
    /// What covers a part of the air behind it.
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
    /// Parallel light is seen from everywhere under one direction.
    OnlyDirectionalLight,
    /// [Culling](crate::culling::is_worthwhile) has too little to choose from.
    FewBoundedLights,
    /// No light has an area.
    NoArea,
    /// No light has a cookie.
    NoCookie,
    /// Neither hair nor smoke nor a see-through surface lets a share of light through.
    NothingTranslucent,
    /// No see-through surface and no hair is before any of the air.
    NothingCoversTheAir,
}
