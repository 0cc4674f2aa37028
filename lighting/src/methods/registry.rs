//! The list of methods.

use std::fmt;
use std::sync::Arc;

#[cfg(feature = "wgpu")]
use gpu_backend::gpu::{Gpu, Queued, Recording};
use gpu_backend::{Backend, BufferOf, Cpu};

use super::reduced::{Reduced, Reduction};
use super::{
    About, EvaluatorAbout, Frame, LightFrameSurfaces, Method, MethodError, RunOn, SourceAbout,
    Wraps,
};

/// A method that runs on every backend of this build.
///
/// Implemented for every method that does.
#[cfg(not(feature = "wgpu"))]
pub trait RunEverywhere: Method + RunOn<Cpu> {}

#[cfg(not(feature = "wgpu"))]
impl<M: Method + RunOn<Cpu>> RunEverywhere for M {}

/// A method that runs on every backend of this build: on the CPU, on a GPU with a
/// command encoder of its own, and on one with the caller's.
///
/// Implemented for every method that does.
#[cfg(feature = "wgpu")]
pub trait RunEverywhere:
    Method + RunOn<Cpu> + RunOn<Gpu<Queued>> + for<'r> RunOn<Gpu<Recording<'r>>>
{
}

#[cfg(feature = "wgpu")]
impl<M> RunEverywhere for M where
    M: Method + RunOn<Cpu> + RunOn<Gpu<Queued>> + for<'r> RunOn<Gpu<Recording<'r>>>
{
}

/// A method, and the backends on which it runs.
#[derive(Clone)]
pub struct Entry {
    method: Arc<dyn Method>,
    cpu: Arc<dyn RunOn<Cpu>>,
    #[cfg(feature = "wgpu")]
    gpu: Option<OnGpu>,
    pair: Option<Pair>,
}

#[cfg(feature = "wgpu")]
#[derive(Clone)]
struct OnGpu {
    queued: Arc<dyn RunOn<Gpu<Queued>>>,
    recording: Arc<dyn for<'r> RunOn<Gpu<Recording<'r>>>>,
}

/// The two halves of a product.
#[derive(Clone)]
struct Pair {
    visibility: &'static str,
    airlight: &'static str,
    /// The units of their qualities.
    units: [Option<&'static str>; 2],
    titles: [&'static str; 2],
    with_detail: Arc<dyn Fn(u32) -> Entry + Send + Sync>,
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Entry").field(&self.method).finish()
    }
}

impl Entry {
    /// A method that runs on every backend.
    pub fn everywhere<M: RunEverywhere + 'static>(method: M) -> Self {
        let method = Arc::new(method);
        Self {
            method: method.clone(),
            #[cfg(feature = "wgpu")]
            gpu: Some(OnGpu {
                queued: method.clone(),
                recording: method.clone(),
            }),
            cpu: method,
            pair: None,
        }
    }

    /// A method that runs on the CPU alone.
    pub fn on_cpu<M: Method + RunOn<Cpu> + 'static>(method: M) -> Self {
        let method = Arc::new(method);
        Self {
            method: method.clone(),
            cpu: method,
            #[cfg(feature = "wgpu")]
            gpu: None,
            pair: None,
        }
    }

    /// Marks the entry as the product of a source and an evaluator. `with_detail` makes the
    /// same product with another quality of the evaluator.
    pub(super) fn paired(
        self,
        source: SourceAbout,
        evaluator: EvaluatorAbout,
        with_detail: impl Fn(u32) -> Self + Send + Sync + 'static,
    ) -> Self {
        Self {
            pair: Some(Pair {
                visibility: source.name,
                airlight: evaluator.name,
                units: [source.quality.map(|quality| quality.unit), evaluator.unit],
                titles: [source.title, evaluator.title],
                with_detail: Arc::new(with_detail),
            }),
            ..self
        }
    }

    /// What the method says of itself.
    pub fn about(&self) -> About {
        self.method.about()
    }

    /// The method, without a backend.
    pub fn method(&self) -> &dyn Method {
        &*self.method
    }

    /// The method on a backend; `None` if it does not run there.
    pub fn on<B: MethodBackend>(&self) -> Option<&dyn RunOn<B>> {
        B::find(self)
    }

    /// If the method is a product: the names of its visibility source and of its evaluator,
    /// each with the unit of its quality.
    pub fn halves(&self) -> Option<[(&'static str, Option<&'static str>); 2]> {
        let pair = self.pair.as_ref()?;
        Some([
            (pair.visibility, pair.units[0]),
            (pair.airlight, pair.units[1]),
        ])
    }

    /// The same method with less work, on the same backends; see [`reduced`](super::reduced).
    /// Comparisons do not show it. [`Reduction::NONE`] gives the method itself.
    #[must_use]
    pub fn reduced(&self, reduction: Reduction) -> Self {
        if reduction.is_none() {
            return self.clone();
        }
        let reduced = Reduced::new(self.clone(), reduction);
        match self.runs_on_gpus() {
            true => Self::everywhere(reduced),
            false => Self::on_cpu(reduced),
        }
    }

    /// Whether it runs on GPUs; every method runs on the CPU.
    pub fn runs_on_gpus(&self) -> bool {
        #[cfg(feature = "wgpu")]
        return self.gpu.is_some();
        #[cfg(not(feature = "wgpu"))]
        false
    }

    /// True if `filter` is the method's name, visibility or title, or a part of its name or
    /// title. Upper and lower case are the same.
    pub fn matches(&self, filter: &str) -> bool {
        let filter = filter.trim().to_lowercase().replace('×', "x");
        let About { name, title, .. } = self.about();
        let visibility = self.pair.as_ref().map(|pair| pair.visibility);
        !filter.is_empty()
            && (visibility == Some(&filter) || name.contains(&filter) || title.contains(&filter))
    }
}

impl Wraps for Entry {
    type Wrapped = dyn Method;

    fn wrapped(&self) -> &(dyn Method + 'static) {
        &*self.method
    }
}

impl Entry {
    fn runs_on<B: MethodBackend>(&self) -> Result<&dyn RunOn<B>, MethodError> {
        let missing = || MethodError::UnsupportedBackend {
            name: self.about().name.into_owned(),
        };
        self.on().ok_or_else(missing)
    }
}

/// [`MethodError::UnsupportedBackend`] on a backend on which the method does not run.
impl<B: MethodBackend> RunOn<B> for Entry {
    fn prepare(&self, frame: &Frame<'_, B>, quality: u32) -> Result<(), MethodError> {
        self.runs_on()?.prepare(frame, quality)
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        self.runs_on()?.add_radiance(frame, quality, radiance)
    }

    fn surfaces(&self) -> Option<&dyn LightFrameSurfaces<B>> {
        self.on().and_then(RunOn::surfaces)
    }
}

/// A backend on which methods can run.
pub trait MethodBackend: Backend + Sized {
    /// The method of an entry on this backend; `None` if it does not run there.
    fn find(entry: &Entry) -> Option<&dyn RunOn<Self>>;
}

impl MethodBackend for Cpu {
    fn find(entry: &Entry) -> Option<&dyn RunOn<Self>> {
        Some(&*entry.cpu)
    }
}

#[cfg(feature = "wgpu")]
impl MethodBackend for Gpu<Queued> {
    fn find(entry: &Entry) -> Option<&dyn RunOn<Self>> {
        entry.gpu.as_ref().map(|gpu| &*gpu.queued)
    }
}

#[cfg(feature = "wgpu")]
impl<'r> MethodBackend for Gpu<Recording<'r>> {
    fn find(entry: &Entry) -> Option<&dyn RunOn<Self>> {
        let gpu = entry.gpu.as_ref()?;
        let recording: &dyn RunOn<Gpu<Recording<'r>>> = &*gpu.recording;
        Some(recording)
    }
}

/// Methods, in the order of reports. No two share a name.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    entries: Vec<Entry>,
}

impl Registry {
    /// No methods.
    pub fn empty() -> Self {
        Self::default()
    }

    /// All methods that this build has.
    pub fn standard() -> Self {
        let registry = Self::empty()
            .with_all(super::unshadowed::methods())
            .with_all(super::exact::methods())
            .with_all(super::raytraced_area::methods())
            .with_all(super::march::methods())
            .with_all(super::light_space::methods())
            .with_all(super::slices::methods())
            .with_all(super::hybrid::methods())
            .with_all(super::textured::methods())
            .with_all(super::prefiltered::methods())
            .with_all(super::epipolar::methods())
            .with_all(super::light_volumes::methods())
            .with_all(super::froxels::methods());
        #[cfg(feature = "voxel-shadow")]
        let registry = registry.with_all(super::voxelized::methods());
        #[cfg(feature = "area")]
        let registry = registry.with_all(super::area::methods());
        #[cfg(feature = "shadow-dag")]
        let registry = registry.with_all(super::precomputed::methods());
        #[cfg(feature = "translucent")]
        let registry = registry
            .with_all(super::translucent::methods())
            .with_all(super::heterogeneous::methods());
        registry
    }

    /// The same list with one more method, which runs on every backend. It replaces a method of
    /// the same name.
    #[must_use]
    pub fn with<M: RunEverywhere + 'static>(self, method: M) -> Self {
        self.with_all(vec![Entry::everywhere(method)])
    }

    /// The same list with more methods; see [`Registry::with`].
    #[must_use]
    pub fn with_all(mut self, entries: Vec<Entry>) -> Self {
        for entry in entries {
            let name = entry.about().name;
            let same = self.entries.iter().position(|old| old.about().name == name);
            match same {
                Some(index) => self.entries[index] = entry,
                None => self.entries.push(entry),
            }
        }
        self
    }

    /// All methods.
    pub fn all(&self) -> &[Entry] {
        &self.entries
    }

    /// The method to take for heterogeneous media: the first that sees them.
    pub fn for_heterogeneous_media(&self) -> Option<&Entry> {
        self.entries
            .iter()
            .find(|entry| entry.sees_heterogeneous_media())
    }

    /// The methods that comparisons show.
    pub fn compared(&self) -> impl Iterator<Item = &Entry> {
        let all = self.entries.iter();
        all.filter(|entry| !entry.about().qualities.is_empty())
    }

    /// Finds a method by its name or title, or by a part of its name, visibility or title that
    /// no other method has. A name may end in a [reduction](Reduction::of_name), which is then
    /// applied to the method of the rest of the name; a method that is reduced already is not
    /// reduced again.
    pub fn find(&self, name: &str) -> Option<Entry> {
        let name = name.trim().to_lowercase().replace('×', "x");
        self.find_whole(&name).cloned().or_else(|| {
            let (whole, reduction) = Reduction::of_name(&name);
            let is_reduced = |name: &str| !Reduction::of_name(name).1.is_none();
            if reduction.is_none() || is_reduced(whole) {
                return None;
            }
            let entry = self.find_called(whole)?;
            (!is_reduced(&entry.about().name)).then(|| entry.reduced(reduction))
        })
    }

    fn find_whole(&self, name: &str) -> Option<&Entry> {
        self.find_called(name).or_else(|| {
            let mut matching = self.compared().filter(|entry| entry.matches(name));
            let first = matching.next()?;
            matching.next().is_none().then_some(first)
        })
    }

    /// The method with exactly this name or title.
    fn find_called(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| {
            let about = entry.about();
            about.name == name || about.title == name
        })
    }

    /// Names and titles of the visibility sources that pairs are made of.
    pub fn visibilities(&self) -> Vec<[&'static str; 2]> {
        self.halves(|pair| [pair.visibility, pair.titles[0]])
    }

    /// Names and titles of the evaluators that pairs are made of.
    pub fn evaluators(&self) -> Vec<[&'static str; 2]> {
        self.halves(|pair| [pair.airlight, pair.titles[1]])
    }

    fn halves(&self, half: impl Fn(&Pair) -> [&'static str; 2]) -> Vec<[&'static str; 2]> {
        let mut halves = Vec::new();
        for pair in self.entries.iter().filter_map(|entry| entry.pair.as_ref()) {
            if !halves.contains(&half(pair)) {
                halves.push(half(pair));
            }
        }
        halves
    }

    /// The product `visibility` × `airlight`, if there is one, with `detail` as the quality of
    /// the evaluator if it is given.
    pub fn pair(&self, visibility: &str, airlight: &str, detail: Option<u32>) -> Option<Entry> {
        self.entries.iter().find_map(|entry| {
            let pair = entry.pair.as_ref()?;
            let is_it = pair.visibility == visibility && pair.airlight == airlight;
            is_it.then(|| detail.map_or_else(|| entry.clone(), |d| (pair.with_detail)(d)))
        })
    }
}

/// Makes entries of a kind of source with every evaluator, on every backend where the evaluator
/// has a shader. With `many:` they gather many lights in one pass; with `within:` a function
/// makes the method of each pair.
macro_rules! pairs {
    ($sources:expr, $compared:expr) => {
        $crate::methods::registry::pairs!(@all ::std::convert::identity, $sources, $compared)
    };
    (within $method:path: $sources:expr, $compared:expr) => {
        $crate::methods::registry::pairs!(@all $method, $sources, $compared)
    };
    (many: $sources:expr, $compared:expr) => {
        $crate::methods::registry::pairs!(
            @all $crate::methods::many_lights::ManyLights::new, $sources, $compared
        )
    };
    (@all $method:expr, $sources:expr, $compared:expr) => {{
        use $crate::methods::evaluators::*;
        use $crate::methods::registry::pairs;
        vec![
            pairs!(@one everywhere, $method, $sources, $compared, Midpoints),
            pairs!(@one everywhere, $method, $sources, $compared, Gauss),
            pairs!(@one everywhere, $method, $sources, $compared, Tolerances),
            pairs!(@one everywhere, $method, $sources, $compared, Tables),
            pairs!(@one everywhere, $method, $sources, $compared, FrameTables),
            pairs!(@one on_cpu, $method, $sources, $compared, Published),
            pairs!(@one on_cpu, $method, $sources, $compared, Doubles),
        ]
    }};
    (@one $backends:ident, $sources:expr, $compared:expr, $evaluator:ident) => {
        $crate::methods::registry::pairs!(
            @one $backends, ::std::convert::identity, $sources, $compared, $evaluator
        )
    };
    (@one $backends:ident, $method:expr, $sources:expr, $compared:expr, $evaluator:ident) => {{
        use $crate::methods::{Evaluators, PerLight};
        let name = $evaluator::ABOUT.name;
        let compared: &[$crate::methods::Compared] = $compared;
        let compared = compared.iter().find(|c| c.airlight == name).copied();
        let pair = PerLight::new($sources, $evaluator, compared);
        let source = $crate::methods::LightSources::about(&$sources);
        let again = pair.clone();
        let entry = $crate::methods::Entry::$backends($method(pair));
        entry.paired(source, $evaluator::ABOUT, move |detail| {
            let other = again.clone().with_detail(detail);
            $crate::methods::Entry::$backends($method(other))
        })
    }};
}

pub(super) use pairs;
