//! A shader in the making.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};

use super::{Binding, Part, Slot};
use crate::Error;

/// A shader that is put together from parts.
#[derive(Debug)]
pub struct Assembly {
    shared: Vec<&'static str>,
    parts: Vec<Cow<'static, str>>,
    glue: String,
    bindings: Vec<Binding>,
}

impl Assembly {
    /// Starts with text that every such shader has: libraries, the entry point
    /// and its bindings.
    pub fn new(shared: &[&'static str]) -> Self {
        Self {
            shared: shared.to_vec(),
            parts: Vec::new(),
            glue: String::new(),
            bindings: Vec::new(),
        }
    }

    /// Puts a part into a slot.
    ///
    /// # Errors
    /// [`Error::Rejected`] if a variable of the part has the name of one that is
    /// there already: two parts of one kind do not meet in one shader.
    pub fn fill<S: Slot>(&mut self, part: &Part) -> Result<(), Error> {
        for binding in part.bindings() {
            if self.bindings.iter().any(|other| other.name == binding.name) {
                return Err(Error::Rejected {
                    what: format!("the part {} of a shader", part.name()),
                    reason: format!(
                        "two parts have the variable {}: parts of one kind do not meet in one shader",
                        binding.name
                    ),
                });
            }
            self.bindings.push(*binding);
        }
        for text in part.texts() {
            let is_shared = self.shared.iter().any(|other| *other == text.as_ref());
            if !is_shared && !self.parts.contains(text) {
                self.parts.push(text.clone());
            }
        }
        self.glue += &S::glue(part.name());
        Ok(())
    }

    /// The variables of all parts, in the order of their binding numbers.
    pub fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// All text, with the variables of the parts in the bind group `group`,
    /// numbered as they came.
    ///
    /// Generated text is kept for the life of the program, once for each
    /// combination of parts, so that pipelines can be found by where their text
    /// is.
    pub fn finish(self, group: u32) -> Vec<&'static str> {
        let declared: String = (0..)
            .zip(&self.bindings)
            .map(|(binding, variable)| variable.declaration(group, binding))
            .collect();
        let mut texts = self.shared;
        for part in self.parts {
            texts.push(match part {
                Cow::Borrowed(text) => text,
                Cow::Owned(text) => kept(text),
            });
        }
        texts.push(kept(declared + &self.glue));
        texts
    }
}

/// The same text, for the life of the program.
fn kept(text: String) -> &'static str {
    static TEXTS: Mutex<Option<HashSet<&'static str>>> = Mutex::new(None);
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    let texts = texts.get_or_insert_default();
    match texts.get(text.as_str()) {
        Some(same) => same,
        None => {
            let text: &'static str = Box::leak(text.into_boxed_str());
            texts.insert(text);
            text
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Answer;

    impl Slot for Answer {
        fn glue(part: &str) -> String {
            format!("fn answer() -> f32 {{ return {part}_answer(); }}\n")
        }
    }

    fn part(name: &'static str, variable: &'static str) -> Part {
        Part::new(name)
            .source("const x_LIBRARY: u32 = 1u;")
            .source(format!(
                "fn {name}_answer() -> f32 {{ return {variable}[0]; }}"
            ))
            .uniform("x_size", "u32")
            .read(variable, "array<f32>")
    }

    #[test]
    fn text_is_there_once_and_bindings_are_numbered_as_they_come() {
        let mut shader = Assembly::new(&["const x_LIBRARY: u32 = 1u;"]);
        shader.fill::<Answer>(&part("x_first", "x_a")).unwrap();
        let parts = shader.finish(2);
        let text = parts.join("\n");
        assert_eq!(text.matches("x_LIBRARY").count(), 1);
        assert!(text.contains("@group(2) @binding(0) var<uniform> x_size: u32;"));
        assert!(text.contains("@group(2) @binding(1) var<storage> x_a: array<f32>;"));
        assert!(text.contains("fn answer() -> f32 { return x_first_answer(); }"));
    }

    #[test]
    fn the_same_parts_give_the_same_text_at_the_same_place() {
        let assembled = || {
            let mut shader = Assembly::new(&[]);
            shader.fill::<Answer>(&part("x_same", "x_b")).unwrap();
            shader.finish(0)
        };
        let (a, b) = (assembled(), assembled());
        assert_eq!(a.len(), b.len());
        assert!(a.iter().zip(&b).all(|(a, b)| std::ptr::eq(*a, *b)));
    }

    #[test]
    fn two_parts_with_one_variable_are_refused_by_name() {
        let mut shader = Assembly::new(&[]);
        shader.fill::<Answer>(&part("x_one", "x_c")).unwrap();
        let error = shader.fill::<Answer>(&part("x_two", "x_d")).unwrap_err();
        assert!(error.to_string().contains("x_size"), "{error}");
    }
}
