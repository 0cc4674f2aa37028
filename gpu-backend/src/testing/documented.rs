//! What pages say of shaders, compared with the shaders.

use super::{Shader, ShaderError};

/// A function or a structure as a page has it.
#[derive(Debug, PartialEq)]
struct Item {
    name: String,
    /// Parameters or members: name and type.
    fields: Vec<(String, String)>,
    /// What a function returns; the name of a structure.
    result: Option<String>,
    is_function: bool,
}

impl Shader {
    /// Compares the signatures on a page with the shader that is made of `parts`,
    /// and returns the names of what the page describes, in its order.
    ///
    /// Looked at are the code blocks marked `wgsl` in Markdown, as it is or in
    /// comments of Rust (`///`, `//!`). A function without a body is a signature; a
    /// structure must have all its members. Functions with a body and statements
    /// are examples and left out. Names and types of parameters, members and results
    /// must be those of the shader.
    ///
    /// # Errors
    /// [`ShaderError::NotFound`] for what the shader does not have,
    /// [`ShaderError::Documentation`] for other names, [`ShaderError::Invalid`] for
    /// other types: the report shows a function that was written from the page.
    pub fn documented(parts: &[&str], page: &str) -> Result<Vec<String>, ShaderError> {
        let shader = Self::new(parts)?;
        let items: Vec<Item> = blocks(page).iter().flat_map(|text| items(text)).collect();
        let probes: String = items.iter().zip(0..).map(Item::probe).collect();
        for item in &items {
            item.compare(&shader)?;
        }
        Self::new(&[parts, &[&probes]].concat())?;
        Ok(items.into_iter().map(|item| item.name).collect())
    }
}

impl Item {
    /// A function that compiles if the types are those of the shader: none of WGSL
    /// becomes another by itself.
    fn probe(pair: (&Self, usize)) -> String {
        let (item, number) = pair;
        let list = |with_types: bool| -> String {
            let each = item.fields.iter().map(|(name, ty)| {
                if with_types {
                    format!("{name}: {ty}")
                } else {
                    name.clone()
                }
            });
            each.collect::<Vec<_>>().join(", ")
        };
        let (parameters, arguments, name) = (list(true), list(false), &item.name);
        match &item.result {
            Some(ty) => {
                format!(
                    "fn documented_{number}({parameters}) -> {ty} {{ return {name}({arguments}); }}\n"
                )
            }
            None => format!("fn documented_{number}({parameters}) {{ {name}({arguments}); }}\n"),
        }
    }

    /// Compares the names.
    fn compare(&self, shader: &Shader) -> Result<(), ShaderError> {
        let written: Vec<&str> = self.fields.iter().map(|(name, _)| name.as_str()).collect();
        let (found, returns) = if self.is_function {
            shader.parameters(&self.name)?
        } else {
            let members = shader.layout(&self.name)?.members;
            (members.into_iter().map(|m| m.name).collect(), true)
        };
        let differs = |difference| {
            Err(ShaderError::Documentation {
                name: self.name.clone(),
                difference,
            })
        };
        if written != found {
            return differs(format!("the page has {written:?}, the shader {found:?}"));
        }
        if returns != self.result.is_some() {
            return differs(format!(
                "that the shader {} a value is not so on the page",
                if returns {
                    "returns"
                } else {
                    "does not return"
                }
            ));
        }
        Ok(())
    }
}

/// The code blocks of a page that are marked `wgsl`.
fn blocks(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut block: Option<String> = None;
    for line in page.lines() {
        let trimmed = line.trim_start();
        let text = match trimmed.strip_prefix("///").or(trimmed.strip_prefix("//!")) {
            Some(comment) => comment.strip_prefix(' ').unwrap_or(comment),
            None => line,
        };
        match &mut block {
            None if text.trim() == "```wgsl" => block = Some(String::new()),
            None => {}
            Some(_) if text.trim() == "```" => blocks.extend(block.take()),
            Some(block) => {
                *block += text.split("//").next().unwrap_or_default();
                block.push('\n');
            }
        }
    }
    blocks
}

/// The signatures and structures of a block.
fn items(block: &str) -> Vec<Item> {
    let mut items = Vec::new();
    let mut rest = block;
    while let Some((line, after)) = rest.split_once('\n') {
        let is_function = line.starts_with("fn ");
        if !is_function && !line.starts_with("struct ") {
            rest = after;
            continue;
        }
        let brackets = if is_function { ['(', ')'] } else { ['{', '}'] };
        let Some([open, close]) = pair(rest, brackets) else {
            return items;
        };
        let name = rest[..open].split_whitespace().nth(1).unwrap_or_default();
        let fields = fields(&rest[open + 1..close]);
        let behind = &rest[close + 1..];
        let end = behind.find('\n').unwrap_or(behind.len());
        let (line, after) = behind.split_at(end);
        let returned = line
            .trim()
            .strip_prefix("->")
            .map(|ty| ty.trim().to_owned());
        if is_function && line.contains('{') {
            // An example with a body.
            let Some([_, close]) = pair(behind, ['{', '}']) else {
                return items;
            };
            rest = &behind[close + 1..];
            continue;
        }
        items.push(Item {
            name: name.to_owned(),
            fields,
            result: if is_function {
                returned
            } else {
                Some(name.to_owned())
            },
            is_function,
        });
        rest = after;
    }
    items
}

/// Where the first bracket and the one that closes it are.
fn pair(text: &str, [open, close]: [char; 2]) -> Option<[usize; 2]> {
    let first = text.find(open)?;
    let mut depth = 0;
    for (at, letter) in text[first..].char_indices() {
        if letter == open {
            depth += 1;
        } else if letter == close {
            depth -= 1;
            if depth == 0 {
                return Some([first, first + at]);
            }
        }
    }
    None
}

/// Names and types, separated by commas outside of `<>`.
fn fields(list: &str) -> Vec<(String, String)> {
    let mut depth = 0;
    let parts = list.split(|letter| {
        match letter {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ => {}
        }
        letter == ',' && depth == 0
    });
    parts
        .filter_map(|field| field.split_once(':'))
        .map(|(name, ty)| (name.trim().to_owned(), ty.trim().to_owned()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: &str = "
        struct t_Node { depth: f32, colour: vec3<f32> }
        fn t_f(n: t_Node, k: ptr<function, u32>) -> f32 { *k += 1u; return n.depth; }
        fn t_g(x: array<f32, 3>) {}
    ";

    fn said(signature: &str) -> Result<Vec<String>, ShaderError> {
        Shader::documented(&[PART], &format!("/// ```wgsl\n/// {signature}\n/// ```\n"))
    }

    #[test]
    fn what_is_right_is_listed_and_examples_are_left_out() {
        let page = "
            //! ```wgsl
            //! struct t_Node {
            //!     depth: f32, // in metres
            //!     colour: vec3<f32>,
            //! }
            //! fn t_f(
            //!     n: t_Node,
            //!     k: ptr<function, u32>,
            //! ) -> f32
            //! fn mine(x: f32) -> f32 {
            //!     return x;
            //! }
            //! fn t_g(x: array<f32, 3>)
            //! ```
            //! ```wgsl
            //! let x = t_f(n, &k);
            //! ```
        ";
        let names = Shader::documented(&[PART], page).unwrap();
        assert_eq!(names, ["t_Node", "t_f", "t_g"]);
    }

    #[test]
    fn every_difference_is_seen() {
        for wrong in [
            "fn t_f(n: t_Node) -> f32",
            "fn t_f(m: t_Node, k: ptr<function, u32>) -> f32",
            "fn t_f(n: t_Node, k: ptr<function, i32>) -> f32",
            "fn t_f(n: t_Node, k: ptr<function, u32>) -> u32",
            "fn t_f(n: t_Node, k: ptr<function, u32>)",
            "fn t_g(x: array<f32, 3>) -> f32",
            "fn t_g(x: array<f32, 4>)",
            "fn t_h()",
            "struct t_Node { depth: f32 }",
            "struct t_Node { depth: f32, colour: vec3<u32> }",
            "struct t_Node { depth: f32, color: vec3<f32> }",
        ] {
            assert!(said(wrong).is_err(), "{wrong}");
        }
    }
}
