//! Sockets of shaders that are no reflection of a surface: what fills it, what sends rays elsewhere, and fibres of hair.

use super::{Legal, Socket, SocketKind};

sockets! {
    /// Inputs of the Ray Portal BSDF.
    ray_portal {
        COLOR: Color "Color" = [1.0; 3], Legal::ALBEDO;
        POSITION: Vector "Position" = [0.0; 3], Legal::ANY;
        DIRECTION: Vector "Direction" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Hair BSDF; roughness along the strand and around it.
    hair {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        OFFSET: Float "Offset" = [0.0; 3], Legal::ANY;
        ROUGHNESS_U: Float "RoughnessU" = [0.1; 3], Legal::share(0.1);
        ROUGHNESS_V: Float "RoughnessV" = [1.0; 3], Legal::share(1.0);
        TANGENT: Normal "Tangent" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Principled Hair BSDF, by Blender's identifiers. Without a link to Random the strand's own number stands for it.
    principled_hair {
        COLOR: Color "Color" = [0.017513, 0.005763, 0.002059], Legal::positive(0.0);
        MELANIN: Float "Melanin" = [0.8; 3], Legal::ANY;
        MELANIN_REDNESS: Float "Melanin Redness" = [1.0; 3], Legal::ANY;
        TINT: Color "Tint" = [1.0; 3], Legal::positive(1.0);
        ABSORPTION: Vector "Absorption Coefficient" = [0.245531, 0.52, 1.365], Legal::positive(0.0);
        ASPECT_RATIO: Float "Aspect Ratio" = [0.85; 3], Legal::positive(1.0);
        ROUGHNESS: Float "Roughness" = [0.3; 3], Legal::ANY;
        RADIAL_ROUGHNESS: Float "Radial Roughness" = [0.3; 3], Legal::ANY;
        COAT: Float "Coat" = [0.0; 3], Legal::share(0.0);
        IOR: Float "IOR" = [1.55; 3], Legal::ANY;
        OFFSET: Float "Offset" = [0.0349066; 3], Legal::ANY;
        RANDOM_COLOR: Float "Random Color" = [0.0; 3], Legal::share(0.0);
        RANDOM_ROUGHNESS: Float "Random Roughness" = [0.0; 3], Legal::ANY;
        RANDOM: Float "Random" = [0.0; 3], Legal::ANY;
        REFLECTION: Float "R lobe" = [1.0; 3], Legal::positive(1.0);
        TRANSMISSION: Float "TT lobe" = [1.0; 3], Legal::positive(1.0);
        SECONDARY_REFLECTION: Float "TRT lobe" = [1.0; 3], Legal::positive(1.0);
    }
}
sockets! {
    /// Inputs of the Volume Absorption.
    volume_absorption {
        COLOR: Color "Color" = [0.8; 3], Legal::ANY;
        DENSITY: Float "Density" = [1.0; 3], Legal::positive(0.0);
    }
}
sockets! {
    /// Inputs of the Volume Scatter.
    volume_scatter {
        COLOR: Color "Color" = [0.8; 3], Legal::positive(0.0);
        DENSITY: Float "Density" = [1.0; 3], Legal::positive(0.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        IOR: Float "IOR" = [1.33; 3], Legal::positive(1.33);
        BACKSCATTER: Float "Backscatter" = [0.1; 3], Legal::share(0.1);
        ALPHA: Float "Alpha" = [0.5; 3], Legal::positive(0.5);
        DIAMETER: Float "Diameter" = [20.0; 3], Legal::positive(20.0);
    }
}
sockets! {
    /// Inputs of the Volume Coefficients.
    volume_coefficients {
        ABSORPTION: Vector "Absorption Coefficients" = [1.0; 3], Legal::positive(0.0);
        SCATTER: Vector "Scatter Coefficients" = [1.0; 3], Legal::positive(0.0);
        EMISSION: Vector "Emission Coefficients" = [0.0; 3], Legal::positive(0.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        IOR: Float "IOR" = [1.33; 3], Legal::positive(1.33);
        BACKSCATTER: Float "Backscatter" = [0.1; 3], Legal::share(0.1);
        ALPHA: Float "Alpha" = [0.5; 3], Legal::positive(0.5);
        DIAMETER: Float "Diameter" = [20.0; 3], Legal::positive(20.0);
    }
}
sockets! {
    /// Inputs of the Principled Volume; what it emits for its temperature is not among them.
    principled_volume {
        COLOR: Color "Color" = [0.5; 3], Legal::positive(0.0);
        DENSITY: Float "Density" = [1.0; 3], Legal::positive(0.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        ABSORPTION_COLOR: Color "Absorption Color" = [0.0; 3], Legal::positive(0.0);
        EMISSION_STRENGTH: Float "Emission Strength" = [0.0; 3], Legal::positive(0.0);
        EMISSION_COLOR: Color "Emission Color" = [1.0; 3], Legal::positive(0.0);
    }
}
