//! What a part of a shader is.

use std::borrow::Cow;

/// Text and the declarations of the data that it reads.
///
/// Nothing in it depends on a value: two values of a type have the same part, and
/// share a pipeline.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    name: &'static str,
    sources: Vec<Cow<'static, str>>,
    bindings: Vec<Binding>,
}

/// A module-scope variable that a part reads or writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Name of the variable.
    pub name: &'static str,
    /// Its type, as WGSL writes it.
    pub ty: &'static str,
    /// How it is bound.
    pub kind: BindingKind,
}

/// How a variable is bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BindingKind {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage>`.
    Read,
    /// `var<storage, read_write>`.
    Write,
    /// A texture.
    Texture,
    /// A sampler.
    Sampler,
}

impl BindingKind {
    /// True if it counts against the storage buffers of a shader stage, of which
    /// WebGPU grants eight.
    pub fn is_storage(self) -> bool {
        matches!(self, Self::Read | Self::Write)
    }
}

impl Binding {
    /// The variable's declaration.
    pub fn declaration(&self, group: u32, binding: u32) -> String {
        let space = match self.kind {
            BindingKind::Uniform => "<uniform>",
            BindingKind::Read => "<storage>",
            BindingKind::Write => "<storage, read_write>",
            BindingKind::Texture | BindingKind::Sampler => "",
        };
        let Self { name, ty, .. } = self;
        format!("@group({group}) @binding({binding}) var{space} {name}: {ty};\n")
    }
}

impl Part {
    /// A part without text, whose functions will be called `name_…`. The name
    /// begins with the prefix of its crate.
    pub const fn new(name: &'static str) -> Self {
        Self {
            name,
            sources: Vec::new(),
            bindings: Vec::new(),
        }
    }

    /// Adds text. Texts that several parts add, such as a library of functions,
    /// are in a shader once.
    #[must_use]
    pub fn source(mut self, text: impl Into<Cow<'static, str>>) -> Self {
        let text = text.into();
        if !self.sources.contains(&text) {
            self.sources.push(text);
        }
        self
    }

    /// Adds several texts.
    #[must_use]
    pub fn sources(self, texts: &[&'static str]) -> Self {
        texts.iter().fold(self, |part, text| part.source(*text))
    }

    /// Adds all of another part, without its name: its bindings come next.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        self.bindings.extend(other.bindings);
        other.sources.into_iter().fold(self, Self::source)
    }

    /// Adds the lines that put a part into a slot.
    #[must_use]
    pub fn glue<S: super::Slot>(self, part: &Part) -> Self {
        self.source(S::glue(part.name))
    }

    /// Adds a variable, bound as the next argument.
    #[must_use]
    pub fn bind(mut self, binding: Binding) -> Self {
        self.bindings.push(binding);
        self
    }

    /// Adds a uniform.
    #[must_use]
    pub fn uniform(self, name: &'static str, ty: &'static str) -> Self {
        let kind = BindingKind::Uniform;
        self.bind(Binding { name, ty, kind })
    }

    /// Adds a buffer that is read.
    #[must_use]
    pub fn read(self, name: &'static str, ty: &'static str) -> Self {
        let kind = BindingKind::Read;
        self.bind(Binding { name, ty, kind })
    }

    /// Adds a texture, such as one of the type `texture_depth_2d_array`.
    #[must_use]
    pub fn texture(self, name: &'static str, ty: &'static str) -> Self {
        let kind = BindingKind::Texture;
        self.bind(Binding { name, ty, kind })
    }

    /// Adds a sampler, of the type `sampler` or `sampler_comparison`.
    #[must_use]
    pub fn sampler(self, name: &'static str, ty: &'static str) -> Self {
        let kind = BindingKind::Sampler;
        self.bind(Binding { name, ty, kind })
    }

    /// What its functions begin with.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Its texts, in order.
    pub fn texts(&self) -> impl Iterator<Item = &Cow<'static, str>> {
        self.sources.iter()
    }

    /// Its variables, in the order of the arguments.
    pub fn bindings(&self) -> &[Binding] {
        &self.bindings
    }
}
