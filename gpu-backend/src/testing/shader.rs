//! WGSL checked by the same compiler that wgpu uses.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Expression, Literal, Module, ScalarKind, TypeInner};

/// A module assembled from parts and found valid within WebGPU's defaults: no
/// optional features.
#[derive(Debug)]
pub struct Shader {
    module: Module,
    info: ModuleInfo,
}

/// What is wrong with a shader, or differs from Rust.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShaderError {
    /// The text is not WGSL, or not valid.
    #[error("{report}")]
    Invalid {
        /// The compiler's report, with lines.
        report: String,
    },
    /// There is no such thing in the module. Constants without a type disappear
    /// when they are used: give every shared constant one.
    #[error("the shader has no {what} called {name}")]
    NotFound {
        /// A structure, a function, a constant, an override.
        what: &'static str,
        /// What was looked for.
        name: String,
    },
    /// A structure is laid out differently in Rust.
    #[error("{name}: {difference}")]
    Layout {
        /// The structure.
        name: String,
        /// Where they differ.
        difference: String,
    },
    /// A page says something else of a function or structure.
    #[error("{name}: {difference}")]
    Documentation {
        /// The function or structure.
        name: String,
        /// Where they differ.
        difference: String,
    },
    /// A part for other people's shaders holds what only an entry point's file
    /// may, or a name that could collide.
    #[error("a part with the prefix {prefix} must not have {what}")]
    NotAPart {
        /// The crate's prefix, or several.
        prefix: String,
        /// What was found.
        what: String,
    },
    /// A value that an override of an integer or truth value would silently
    /// change.
    #[error("override {name} is an integer or a bool and was given {value}")]
    Override {
        /// The override.
        name: String,
        /// The value.
        value: f64,
    },
}

/// How a structure lies in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StructLayout {
    /// Bytes, with the padding at the end: the stride in an array.
    pub size: u32,
    /// Members in order.
    pub members: Vec<Member>,
}

/// A member of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Name.
    pub name: String,
    /// Bytes from the start of the structure.
    pub offset: u32,
    /// Bytes.
    pub size: u32,
}

impl Shader {
    /// Compiles the parts, joined with line breaks as
    /// `Kernel` joins them.
    ///
    /// # Errors
    /// [`ShaderError::Invalid`] with the compiler's report.
    pub fn new(parts: &[&str]) -> Result<Self, ShaderError> {
        let source = parts.join("\n");
        let invalid = |report| ShaderError::Invalid { report };
        let module = naga::front::wgsl::parse_str(&source)
            .map_err(|error| invalid(error.emit_to_string(&source)))?;
        let info = validator()
            .validate(&module)
            .map_err(|error| invalid(error.emit_to_string(&source)))?;
        Ok(Self { module, info })
    }

    /// The module with values for `override` constants put in place, as a
    /// device does before it builds a pipeline. All overrides without a default
    /// must be given.
    ///
    /// # Errors
    /// [`ShaderError::NotFound`] for a value without an override,
    /// [`ShaderError::Override`] for a fraction given to an integer, which a
    /// device would cut off in silence, [`ShaderError::Invalid`] otherwise.
    pub fn specialise(&self, constants: &[(&str, f64)]) -> Result<Self, ShaderError> {
        for &(name, value) in constants {
            let (_, found) = self
                .module
                .overrides
                .iter()
                .find(|(_, o)| o.name.as_deref() == Some(name))
                .ok_or_else(|| not_found("override", name))?;
            let fits = match self.module.types[found.ty].inner {
                TypeInner::Scalar(scalar) => match scalar.kind {
                    ScalarKind::Bool => value == 0.0 || value == 1.0,
                    ScalarKind::Uint => value.fract() == 0.0 && value >= 0.0,
                    ScalarKind::Sint => value.fract() == 0.0,
                    _ => value.is_finite(),
                },
                _ => true,
            };
            if !fits {
                return Err(ShaderError::Override {
                    name: name.into(),
                    value,
                });
            }
        }
        let values = constants
            .iter()
            .map(|(name, value)| ((*name).to_owned(), *value))
            .collect();
        let (module, info) = naga::back::pipeline_constants::process_overrides(
            &self.module,
            &self.info,
            None,
            &values,
        )
        .map_err(|error| ShaderError::Invalid {
            report: error.to_string(),
        })?;
        Ok(Self {
            module: module.into_owned(),
            info: info.into_owned(),
        })
    }

    /// How the structure `name` lies in memory.
    ///
    /// # Errors
    /// [`ShaderError::NotFound`].
    pub fn layout(&self, name: &str) -> Result<StructLayout, ShaderError> {
        let structure = self
            .module
            .types
            .iter()
            .find(|(_, ty)| ty.name.as_deref() == Some(name));
        let Some((
            _,
            naga::Type {
                inner: TypeInner::Struct { members, span },
                ..
            },
        )) = structure
        else {
            return Err(not_found("structure", name));
        };
        let members = members
            .iter()
            .map(|member| Member {
                name: member.name.clone().unwrap_or_default(),
                offset: member.offset,
                size: self.module.types[member.ty]
                    .inner
                    .size(self.module.to_ctx()),
            })
            .collect();
        Ok(StructLayout {
            size: *span,
            members,
        })
    }

    /// The names of the parameters of a function, and whether it returns a value.
    pub(super) fn parameters(&self, name: &str) -> Result<(Vec<String>, bool), ShaderError> {
        let (_, function) = self
            .module
            .functions
            .iter()
            .find(|(_, function)| function.name.as_deref() == Some(name))
            .ok_or_else(|| not_found("function", name))?;
        let names = function.arguments.iter();
        let names = names.map(|argument| argument.name.clone().unwrap_or_default());
        Ok((names.collect(), function.result.is_some()))
    }

    /// Compares a structure with a Rust type of `size` bytes whose fields have
    /// the given offsets. Every member of the WGSL structure must be named,
    /// fields that only pad the Rust type need not be.
    /// [`assert_same_layout!`](crate::assert_same_layout) collects the numbers.
    ///
    /// # Errors
    /// [`ShaderError::NotFound`] and [`ShaderError::Layout`].
    pub fn same_layout(
        &self,
        name: &str,
        size: usize,
        fields: &[(&str, usize)],
    ) -> Result<(), ShaderError> {
        let layout = self.layout(name)?;
        let differs = |difference| {
            Err(ShaderError::Layout {
                name: name.into(),
                difference,
            })
        };
        if layout.size as usize != size {
            return differs(format!("{} bytes in WGSL, {size} in Rust", layout.size));
        }
        if layout.members.len() != fields.len() {
            let members: Vec<_> = layout.members.iter().map(|m| &m.name).collect();
            return differs(format!("the members in WGSL are {members:?}"));
        }
        for (member, (field, offset)) in layout.members.iter().zip(fields) {
            if member.name != *field || member.offset as usize != *offset {
                return differs(format!(
                    "{} at {} in WGSL, {field} at {offset} in Rust",
                    member.name, member.offset
                ));
            }
        }
        Ok(())
    }

    /// The value of a `const`: one number for a scalar, all components in order
    /// for a vector, matrix or array; 1 for true.
    ///
    /// # Errors
    /// [`ShaderError::NotFound`].
    pub fn values(&self, name: &str) -> Result<Vec<f64>, ShaderError> {
        let missing = || not_found("constant", name);
        let (_, constant) = self
            .module
            .constants
            .iter()
            .find(|(_, constant)| constant.name.as_deref() == Some(name))
            .ok_or_else(missing)?;
        let mut values = Vec::new();
        self.flatten(constant.init, &mut values)
            .ok_or_else(missing)?;
        Ok(values)
    }

    fn flatten(&self, expression: naga::Handle<Expression>, values: &mut Vec<f64>) -> Option<()> {
        match &self.module.global_expressions[expression] {
            Expression::Literal(literal) => values.push(match *literal {
                Literal::F64(value) | Literal::AbstractFloat(value) => value,
                Literal::F32(value) => f64::from(value),
                Literal::F16(value) => f64::from(value),
                Literal::U16(value) => f64::from(value),
                Literal::I16(value) => f64::from(value),
                Literal::U32(value) => f64::from(value),
                Literal::I32(value) => f64::from(value),
                Literal::U64(value) => value as f64,
                Literal::I64(value) | Literal::AbstractInt(value) => value as f64,
                Literal::Bool(value) => f64::from(u8::from(value)),
            }),
            Expression::Compose { components, .. } => {
                for component in components {
                    self.flatten(*component, values)?;
                }
            }
            Expression::Splat { size, value } => {
                for _ in 0..*size as u8 {
                    self.flatten(*value, values)?;
                }
            }
            Expression::Constant(constant) => {
                self.flatten(self.module.constants[*constant].init, values)?;
            }
            Expression::ZeroValue(ty) => {
                let inner = &self.module.types[*ty].inner;
                values.resize(
                    values.len() + inner.size(self.module.to_ctx()) as usize / 4,
                    0.0,
                );
            }
            _ => return None,
        }
        Some(())
    }

    /// Checks that the module can be pasted into any shader: no entry points, no
    /// bindings, and every name at module level starts with one of `prefixes`:
    /// the part's own, and those of the parts that it builds on.
    ///
    /// # Errors
    /// [`ShaderError::NotAPart`].
    pub fn require_part(&self, prefixes: &[&str]) -> Result<(), ShaderError> {
        let module = &self.module;
        let reject = |what: String| {
            Err(ShaderError::NotAPart {
                prefix: prefixes.join(" or "),
                what,
            })
        };
        if let Some(entry) = module.entry_points.first() {
            return reject(format!("the entry point {}", entry.name));
        }
        if let Some((_, bound)) = module
            .global_variables
            .iter()
            .find(|(_, variable)| variable.binding.is_some())
        {
            return reject(format!(
                "the binding {}",
                bound.name.as_deref().unwrap_or("_")
            ));
        }
        let names = (module.functions.iter().map(|(_, f)| &f.name))
            .chain(module.constants.iter().map(|(_, c)| &c.name))
            .chain(module.overrides.iter().map(|(_, o)| &o.name))
            .chain(module.global_variables.iter().map(|(_, v)| &v.name))
            .chain(module.types.iter().map(|(_, t)| &t.name));
        match names
            .flatten()
            .find(|name| !prefixes.iter().any(|prefix| name.starts_with(prefix)))
        {
            Some(name) => reject(format!("the name {name}")),
            None => Ok(()),
        }
    }
}

/// Compares a WGSL structure with a `#[repr(C)]` type and panics where they
/// differ. Call it where the fields are visible; list the fields in the order
/// of the WGSL structure.
///
/// See [`testing`](crate::testing) for an example.
#[macro_export]
macro_rules! assert_same_layout {
    ($shader:expr, $name:expr, $type:ty { $($field:ident),* $(,)? }) => {
        if let Err(difference) = $shader.same_layout(
            $name,
            ::core::mem::size_of::<$type>(),
            &[$((stringify!($field), ::core::mem::offset_of!($type, $field))),*],
        ) {
            panic!("{difference}");
        }
    };
}

fn validator() -> Validator {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
}

fn not_found(what: &'static str, name: &str) -> ShaderError {
    ShaderError::NotFound {
        what,
        name: name.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: &str = "
        struct t_Node { depth: f32, colour: vec3<f32> }
        const t_WIDTH: u32 = 8;
        const t_POLYNOMIAL = array<f32, 3>(1.0, -0.5, 0.25);
        const t_TWICE: u32 = 2 * t_WIDTH;
        const t_UNTYPED = 3;
        override t_STEPS: u32 = 4;
        fn t_f(n: t_Node) -> f32 { return n.depth * f32(t_WIDTH + t_STEPS + t_UNTYPED); }
        // A comment at the end";

    #[repr(C)]
    struct Node {
        depth: f32,
        padding: [f32; 3],
        colour: [f32; 3],
        end: f32,
    }

    #[test]
    fn structures_and_constants_are_found_as_written() {
        let shader = Shader::new(&[PART, "const t_LAST: f32 = 1.5;"]).unwrap();
        shader.require_part(&["t_"]).unwrap();
        assert_same_layout!(shader, "t_Node", Node { depth, colour });
        assert_eq!(shader.values("t_WIDTH").unwrap(), [8.0]);
        assert_eq!(shader.values("t_TWICE").unwrap(), [16.0]);
        assert_eq!(shader.values("t_POLYNOMIAL").unwrap(), [1.0, -0.5, 0.25]);
        assert_eq!(shader.values("t_LAST").unwrap(), [1.5]);
        assert_eq!(size_of::<Node>(), 32);
    }

    #[test]
    fn what_is_not_there_is_an_error_and_not_a_pass() {
        let shader = Shader::new(&[PART]).unwrap();
        for missing in ["t_UNTYPED", "t_STEPS", "WIDTH", ""] {
            assert!(matches!(
                shader.values(missing),
                Err(ShaderError::NotFound { .. })
            ));
        }
        assert!(shader.layout("t_WIDTH").is_err());
        assert!(shader.same_layout("Node", 32, &[]).is_err());
    }

    #[test]
    fn every_difference_in_layout_is_seen() {
        let shader = Shader::new(&[PART]).unwrap();
        let differs = |size, fields: &[(&str, usize)]| {
            matches!(
                shader.same_layout("t_Node", size, fields),
                Err(ShaderError::Layout { .. })
            )
        };
        assert!(differs(28, &[("depth", 0), ("colour", 16)]));
        assert!(differs(32, &[("depth", 0), ("colour", 4)]));
        assert!(differs(32, &[("depth", 0), ("color", 16)]));
        assert!(differs(32, &[("depth", 0)]));
    }

    #[test]
    fn broken_shaders_are_reported_with_their_lines() {
        for broken in [
            "fn f( {",
            "fn f() -> u32 { return 1.5; }",
            "fn f() { g(); }",
            "fn f() {} fn f() {}",
        ] {
            let error = Shader::new(&["// first line", broken]).unwrap_err();
            assert!(error.to_string().contains("wgsl:2"), "{error}");
        }
    }

    #[test]
    fn what_webgpu_does_not_promise_is_refused() {
        for optional in [
            "enable f16; fn f(x: f16) {}",
            "fn f(x: f64) {}",
            "fn f(x: u64) {}",
            "enable subgroups; fn f() -> u32 { return subgroupAdd(1u); }",
            "var<immediate> x: u32; fn f() -> u32 { return x; }",
        ] {
            assert!(Shader::new(&[optional]).is_err(), "{optional}");
        }
    }

    #[test]
    fn overrides_take_only_values_that_stay_what_they_are() {
        let entry = "@compute @workgroup_size(t_STEPS) fn main() { _ = t_f(t_Node()); }";
        let shader = Shader::new(&[PART, entry]).unwrap();
        shader.specialise(&[("t_STEPS", 32.0)]).unwrap();
        shader.specialise(&[]).unwrap();
        for value in [1.5, -1.0, f64::NAN] {
            assert!(matches!(
                shader.specialise(&[("t_STEPS", value)]),
                Err(ShaderError::Override { .. })
            ));
        }
        assert!(matches!(
            shader.specialise(&[("t_WIDTH", 1.0)]),
            Err(ShaderError::NotFound { .. })
        ));
    }

    #[test]
    fn parts_hold_nothing_that_collides() {
        for (text, culprit) in [
            ("fn f() {}", "f"),
            ("const WIDTH: u32 = 1;", "WIDTH"),
            ("struct S { x: f32 }", "S"),
            ("@group(0) @binding(0) var<storage> t_x: array<f32>;", "t_x"),
            ("@compute @workgroup_size(1) fn t_main() {}", "t_main"),
        ] {
            let error = Shader::new(&[text])
                .and_then(|shader| shader.require_part(&["t_"]))
                .unwrap_err();
            assert!(error.to_string().ends_with(culprit), "{error}");
        }
    }
}
