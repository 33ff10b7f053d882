//! KHR_materials_variants: which material a primitive has in which variant.

use serde::Deserialize;

use super::accessors::Accessors;
use super::document::{self, Document, extension, get};
use super::error::ImportProblem;

#[derive(Deserialize)]
struct Variants {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    material: usize,
    variants: Vec<usize>,
}

/// A primitive's material in each variant of the document, its own where no mapping lists the variant; nothing if it
/// has no mappings. A variant that is listed twice has the first material, with a warning a mapping.
pub(super) fn materials(
    document: &Document,
    accessors: &Accessors,
    primitive: &document::Primitive,
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<Option<usize>>, ImportProblem> {
    let Some(Variants { mappings }) = extension(&primitive.extensions, "KHR_materials_variants", at)? else {
        return Ok(Vec::new());
    };
    let count = document.variants.len();
    accessors.reserve((count * size_of::<Option<usize>>()) as u64, || at.to_owned())?;
    let (mut materials, mut listed) = (vec![primitive.material; count], vec![false; count]);
    for (index, mapping) in mappings.iter().enumerate() {
        let at = format!("{at}.extensions.KHR_materials_variants.mappings[{index}]");
        get(&document.materials, mapping.material, "materials", &at)?;
        let mut repeated = 0;
        for &variant in &mapping.variants {
            get(&document.variants, variant, "extensions.KHR_materials_variants.variants", &at)?;
            if std::mem::replace(&mut listed[variant], true) {
                repeated += 1;
            } else {
                materials[variant] = Some(mapping.material);
            }
        }
        if repeated > 0 {
            warnings.push(format!("{at}: {repeated} variants were listed before; the first material counts"));
        }
    }
    Ok(materials)
}
