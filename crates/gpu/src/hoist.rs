//! Values read once, before anything else.

use std::collections::BTreeMap;

use naga::{
    AddressSpace, ArraySize, Block, Expression, Function, GlobalVariable, Handle, Module, Range, Span, Statement,
    StorageAccess, Type, TypeInner,
};

use crate::Shader;

/// The largest value that a thread holds, bytes.
const MOST_BYTES: u32 = 1024;

/// The module with an entry point that reads every value it uses (`var<storage, read>` of a fixed size) before it branches, into
/// variables of the thread. Values of which elements are chosen at run time stay where they are.
///
/// Mesa's software adapters read what is the same for all threads once, and hand it to all, where they know that every thread is there;
/// behind a branch each thread reads it by itself.
///
/// No value may be handed to a function by pointer.
pub(crate) fn read_first(shader: &Shader, entry: &str) -> Module {
    let mut module = shader.module.clone();
    let index = module.entry_points.iter().position(|it| it.name == entry);
    let (Some(index), Some(used)) = (index, shader.entries.get(entry)) else { return module };
    let functions = || module.functions.iter().map(|(_, it)| it).chain([&module.entry_points[index].function]);
    let values: Vec<Handle<GlobalVariable>> = module
        .global_variables
        .iter()
        .filter(|(handle, it)| {
            used.iter().any(|global| it.name.as_ref() == Some(&global.name))
                && it.space == AddressSpace::Storage { access: StorageAccess::LOAD }
                && has_fixed_size(&module, it.ty)
                && module.types[it.ty].inner.size(module.to_ctx()) <= MOST_BYTES
                && !functions().any(|function| chooses_elements(function, *handle))
        })
        .map(|(handle, _)| handle)
        .collect();
    let mut held = BTreeMap::new();
    for value in values {
        let it = module.global_variables[value].clone();
        let name = it.name.map(|name| format!("{name}_value"));
        let copy = GlobalVariable { name, space: AddressSpace::Private, binding: None, ..it };
        held.insert(value, module.global_variables.append(copy, Span::UNDEFINED));
    }
    let entry = &mut module.entry_points[index].function;
    for function in module.functions.iter_mut().map(|(_, it)| it).chain([&mut *entry]) {
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::GlobalVariable(variable) = expression
                && let Some(copy) = held.get(variable)
            {
                *variable = *copy;
            }
        }
    }
    let mut first = Block::new();
    for (value, copy) in held {
        let mut add = |expression| entry.expressions.append(expression, Span::UNDEFINED);
        let from = add(Expression::GlobalVariable(value));
        let pointer = add(Expression::GlobalVariable(copy));
        let read = add(Expression::Load { pointer: from });
        first.push(Statement::Emit(Range::new_from_bounds(read, read)), Span::UNDEFINED);
        first.push(Statement::Store { pointer, value: read }, Span::UNDEFINED);
    }
    entry.body.splice(0..0, first);
    module
}

fn has_fixed_size(module: &Module, ty: Handle<Type>) -> bool {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => members.iter().all(|member| has_fixed_size(module, member.ty)),
        TypeInner::Array { size, .. } => matches!(size, ArraySize::Constant(_)),
        _ => true,
    }
}

/// Whether a function chooses elements of a value at run time.
fn chooses_elements(function: &Function, value: Handle<GlobalVariable>) -> bool {
    function.expressions.iter().any(|(_, expression)| {
        let Expression::Access { mut base, .. } = *expression else { return false };
        loop {
            match function.expressions[base] {
                Expression::Access { base: inner, .. } | Expression::AccessIndex { base: inner, .. } => base = inner,
                Expression::GlobalVariable(variable) => return variable == value,
                _ => return false,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
        struct Params { scale: f32, place: mat4x4f, starts: vec4u }
        struct Chosen { rows: array<vec4f, 4> }
        @group(0) @binding(0) var<storage, read> params: Params;
        @group(0) @binding(1) var<storage, read> chosen: Chosen;
        @group(0) @binding(2) var<storage, read> rows: array<vec4f>;
        @group(0) @binding(3) var<storage, read_write> sums: array<vec4f>;
        @group(0) @binding(4) var<storage, read> other: vec4f;

        fn scaled(row: u32) -> vec4f {
            return params.scale * (params.place * rows[row]) + chosen.rows[row % 4u];
        }

        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x >= arrayLength(&rows) {
                return;
            }
            sums[id.x] = scaled(id.x) * f32(params.starts.y);
        }

        @compute @workgroup_size(64)
        fn beside(@builtin(global_invocation_id) id: vec3u) {
            sums[id.x] = other;
        }
    ";

    fn globals_read_first(entry: &str) -> Vec<String> {
        let module = read_first(&crate::shader::reflect("test", SOURCE.into()).unwrap(), entry);
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default())
            .validate(&module)
            .unwrap();
        let function = &module.entry_points.iter().find(|it| it.name == entry).unwrap().function;
        let mut names = Vec::new();
        for statement in &*function.body {
            match statement {
                Statement::Emit(_) => {}
                Statement::Store { pointer, value } => {
                    let Expression::GlobalVariable(_) = function.expressions[*pointer] else { break };
                    let Expression::Load { pointer: from } = function.expressions[*value] else { break };
                    let Expression::GlobalVariable(global) = function.expressions[from] else { break };
                    names.push(module.global_variables[global].name.clone().unwrap());
                }
                _ => break,
            }
        }
        names
    }

    #[test]
    fn an_entry_point_reads_the_values_that_it_and_its_functions_use_before_it_branches() {
        assert_eq!(globals_read_first("main"), ["params"]);
        assert_eq!(globals_read_first("beside"), ["other"]);
    }
}
