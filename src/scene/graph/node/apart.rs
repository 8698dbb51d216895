//! Sockets of shaders that are no reflection of a surface: what fills it, and what sends rays elsewhere.

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
