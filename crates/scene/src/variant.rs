//! Material variants: sets of materials that a model may be shown with (KHR_materials_variants).

use crate::Scene;

/// A variant that a model does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no material variant {wanted}; {}", choices(known))]
pub struct VariantError {
    /// The name in quotes, or the index.
    pub wanted: String,
    /// Names of those there are, in order.
    pub known: Vec<String>,
}

fn choices(known: &[String]) -> String {
    if known.is_empty() {
        return "the model has none".to_owned();
    }
    let named: Vec<String> = known.iter().enumerate().map(|(index, name)| format!("{index} \"{name}\"")).collect();
    format!("choose one of {}", named.join(", "))
}

impl Scene {
    /// Index of the first variant of that name.
    ///
    /// # Errors
    /// [`VariantError`] if there is none; it lists those there are.
    pub fn find_variant(&self, name: &str) -> Result<usize, VariantError> {
        let place = self.variants.iter().position(|variant| variant == name);
        place.ok_or_else(|| self.no_variant(format!("\"{name}\"")))
    }

    /// Gives each primitive its material of that variant; one without is left as the file has it. Whatever was selected
    /// before does not matter.
    ///
    /// # Errors
    /// [`VariantError`] if there is no such variant; it lists those there are, and nothing is changed.
    pub fn select_variant(&mut self, index: usize) -> Result<(), VariantError> {
        if index >= self.variants.len() {
            return Err(self.no_variant(index.to_string()));
        }
        for primitive in self.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
            if let Some(&material) = primitive.variant_materials.get(index) {
                primitive.material = material;
            }
        }
        Ok(())
    }

    fn no_variant(&self, wanted: String) -> VariantError {
        VariantError { wanted, known: self.variants.clone() }
    }
}
