# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shader nodes the program evaluates: one table, and what it objects to in a node."""

import typing


class Rule(typing.NamedTuple):
    """What of a node is evaluated; what is not named is."""

    # The values of properties, by the properties' names.
    properties: dict = {}
    # The outputs, by identifier; None for all.
    outputs: frozenset | None = None
    # Inputs, by identifier, that must have no link.
    constant: tuple = ()


ALL = Rule()

EVALUATED = {
    # Inputs
    "ShaderNodeTexCoord": ALL,
    "ShaderNodeUVMap": ALL,
    "ShaderNodeValue": ALL,
    "ShaderNodeRGB": ALL,
    "ShaderNodeBlackbody": ALL,
    "ShaderNodeWavelength": ALL,
    "ShaderNodeFresnel": ALL,
    "ShaderNodeLayerWeight": ALL,
    "ShaderNodeNewGeometry": ALL,
    "ShaderNodeObjectInfo": ALL,
    "ShaderNodeParticleInfo": ALL,
    "ShaderNodeHairInfo": ALL,
    "ShaderNodePointInfo": ALL,
    # Of meshes, which are not filled.
    "ShaderNodeVolumeInfo": ALL,
    "ShaderNodeCameraData": ALL,
    "ShaderNodeLightFalloff": ALL,
    "ShaderNodeLightPath": ALL,
    "ShaderNodeVertexColor": ALL,
    "ShaderNodeAttribute": ALL,
    "ShaderNodeTangent": ALL,
    "ShaderNodeWireframe": ALL,
    "ShaderNodeAmbientOcclusion": ALL,
    "ShaderNodeBevel": ALL,
    "ShaderNodeRaycast": ALL,
    # Textures
    "ShaderNodeTexImage": ALL,
    "ShaderNodeTexNoise": ALL,
    "ShaderNodeTexVoronoi": ALL,
    "ShaderNodeTexWave": ALL,
    "ShaderNodeTexMagic": ALL,
    "ShaderNodeTexBrick": ALL,
    "ShaderNodeTexChecker": ALL,
    "ShaderNodeTexGradient": ALL,
    "ShaderNodeTexWhiteNoise": ALL,
    "ShaderNodeTexGabor": ALL,
    "ShaderNodeTexEnvironment": ALL,
    "ShaderNodeTexSky": ALL,
    "ShaderNodeTexIES": ALL,
    # Numbers
    "ShaderNodeMath": ALL,
    # Of Blender from 5.3 on.
    "FunctionNodeIntegerMath": ALL,
    "FunctionNodeBooleanMath": ALL,
    "FunctionNodeGetVectorComponent": ALL,
    "ShaderNodeFloatCurve": ALL,
    "ShaderNodeMapRange": ALL,
    "ShaderNodeClamp": ALL,
    # Vectors
    "ShaderNodeMapping": ALL,
    "ShaderNodeVectorMath": ALL,
    "ShaderNodeVectorCurve": ALL,
    "ShaderNodeVectorRotate": ALL,
    "ShaderNodeVectorTransform": ALL,
    "ShaderNodeRadialTiling": ALL,
    "ShaderNodeCombineXYZ": ALL,
    "ShaderNodeSeparateXYZ": ALL,
    "ShaderNodeNormal": ALL,
    "ShaderNodeNormalMap": ALL,
    "ShaderNodeBump": ALL,
    "ShaderNodeDisplacement": ALL,
    "ShaderNodeVectorDisplacement": ALL,
    # Colours
    "ShaderNodeMix": Rule({"data_type": {"FLOAT", "VECTOR", "RGBA"}}),
    "ShaderNodeMixRGB": ALL,
    "ShaderNodeValToRGB": ALL,
    "ShaderNodeRGBCurve": ALL,
    "ShaderNodeCombineColor": ALL,
    "ShaderNodeSeparateColor": ALL,
    # Of Blender before 5.0.
    "ShaderNodeCombineRGB": ALL,
    "ShaderNodeCombineHSV": ALL,
    "ShaderNodeSeparateRGB": ALL,
    "ShaderNodeSeparateHSV": ALL,
    "ShaderNodeHueSaturation": ALL,
    "ShaderNodeBrightContrast": ALL,
    "ShaderNodeGamma": ALL,
    "ShaderNodeInvert": ALL,
    "ShaderNodeRGBToBW": ALL,
    # Shaders
    "ShaderNodeBsdfPrincipled": Rule(constant=("Thin Wall",)),
    "ShaderNodeSubsurfaceScattering": ALL,
    "ShaderNodeBsdfDiffuse": ALL,
    "ShaderNodeBsdfGlossy": ALL,
    # What the Glossy BSDF is called from 4.0 on.
    "ShaderNodeBsdfAnisotropic": ALL,
    "ShaderNodeBsdfTranslucent": ALL,
    "ShaderNodeBsdfRefraction": ALL,
    "ShaderNodeBsdfGlass": ALL,
    "ShaderNodeBsdfMetallic": ALL,
    "ShaderNodeBsdfSheen": ALL,
    "ShaderNodeBsdfToon": ALL,
    "ShaderNodeBsdfHair": ALL,
    "ShaderNodeBsdfHairPrincipled": ALL,
    "ShaderNodeBsdfTransparent": ALL,
    "ShaderNodeBsdfRayPortal": ALL,
    "ShaderNodeEmission": ALL,
    "ShaderNodeBackground": ALL,
    # Alone; what it does in mixes is told.
    "ShaderNodeHoldout": ALL,
    "ShaderNodeMixShader": ALL,
    "ShaderNodeAddShader": ALL,
}

# What a Raycast tells apart from attributes of what it meets.
RAY_OUTPUTS = frozenset({"Is Hit", "Self Hit", "Hit Distance", "Hit Position", "Hit Normal"})

# Textures whose coordinates are the generated ones, where nothing is linked.
GENERATED = {
    f"ShaderNodeTex{name}" for name in ("Noise", "Voronoi", "Wave", "Magic", "Brick", "Checker", "Gradient", "Gabor", "Musgrave")
}

# What there is of nodes in the trees of worlds and of lights, where it is other than on surfaces.
_OF_WORLDS = {
    "ShaderNodeBackground": ALL,
    "ShaderNodeTexEnvironment": ALL,
    "ShaderNodeTexSky": ALL,
    "ShaderNodeNewGeometry": Rule(
        outputs=frozenset({"Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing"})
    ),
}

_RAY_KINDS = frozenset({
    "Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Is Transmission Ray", "Is Volume Scatter Ray",
})  # fmt: skip
_OF_WORLDS["ShaderNodeLightPath"] = Rule(outputs=_RAY_KINDS | {"Ray Length", "Ray Depth"})

_ON_SURFACES = (
    "ShaderNodeParticleInfo", "ShaderNodeHairInfo", "ShaderNodePointInfo", "ShaderNodeVolumeInfo", "ShaderNodeTangent", "ShaderNodeWireframe",
    "ShaderNodeAmbientOcclusion", "ShaderNodeBevel", "ShaderNodeRaycast", "ShaderNodeHoldout",
    "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfTransparent",
    "ShaderNodeObjectInfo", "ShaderNodeVertexColor", "ShaderNodeAttribute", "ShaderNodeNormalMap", "ShaderNodeBump",
)  # fmt: skip
_OF_LIGHTS = {
    "ShaderNodeTexIES": ALL,
    "ShaderNodeTexEnvironment": _OF_WORLDS["ShaderNodeTexEnvironment"],
    "ShaderNodeNewGeometry": _OF_WORLDS["ShaderNodeNewGeometry"],
    "ShaderNodeLightPath": _OF_WORLDS["ShaderNodeLightPath"],
    # Around lamps there is nothing: all is open, and no edge is near.
    "ShaderNodeAmbientOcclusion": ALL,
    "ShaderNodeBevel": ALL,
}


def _without_surfaces(rules, others):
    # Of the textures of worlds and of lamps, each has its own alone.
    left_out = {*_ON_SURFACES, *others} - rules.keys()
    return {kind: rule for kind, rule in {**EVALUATED, **rules}.items() if kind not in left_out}


LIGHT = _without_surfaces(_OF_LIGHTS, {"ShaderNodeTexSky": ALL})
WORLD = _without_surfaces(_OF_WORLDS, {"ShaderNodeTexIES": ALL})

_IN_VOLUMES = {
    "ShaderNodeVolumeAbsorption": ALL,
    "ShaderNodeVolumeScatter": ALL,
    "ShaderNodeVolumeCoefficients": ALL,
    "ShaderNodeVolumePrincipled": ALL,
    # The surface's normal is the way that light comes from.
    "ShaderNodeNewGeometry": Rule(
        outputs=frozenset({"Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing"})
    ),
}
# What asks for surfaces.
_NOT_IN_VOLUMES = {
    kind
    for kind in EVALUATED
    if kind.startswith("ShaderNodeBsdf") or kind in {*_ON_SURFACES, "ShaderNodeSubsurfaceScattering", "ShaderNodeBackground",
    "ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"}
} - {"ShaderNodeObjectInfo", "ShaderNodeParticleInfo", "ShaderNodeAttribute", "ShaderNodeVertexColor"}  # fmt: skip
VOLUME = {kind: rule for kind, rule in {**EVALUATED, **_IN_VOLUMES}.items() if kind not in _NOT_IN_VOLUMES}
# What is filled by grids.
VOLUME_OF_GRIDS = {**VOLUME, "ShaderNodeVolumeInfo": ALL}
_OF_OBJECTS = {"ShaderNodeObjectInfo", "ShaderNodeParticleInfo", "ShaderNodeAttribute"}
VOLUME_OF_WORLD = {kind: rule for kind, rule in VOLUME.items() if kind not in _OF_OBJECTS}

# What is not evaluated for all that it is not a property of its own.
IMAGE_SOURCES = {"FILE", "GENERATED", "TILED", "MOVIE"}


def objections(node, inputs, outputs, table=None):
    """What the program does not evaluate of a node, by words that name it; nothing if it evaluates all.

    `inputs` has the numbers of unlinked inputs, and something else for links; `outputs` the identifiers in use; `table` the
    rules of the tree's kind, those of materials by default.
    """
    label = node.bl_label
    rule = (EVALUATED if table is None else table).get(node.bl_idname)
    if rule is None:
        yield label
        return
    for name, values in rule.properties.items():
        value = getattr(node, name, None)
        if value is not None and value not in values:
            words = node.bl_rna.properties[name].name
            yield f"{label} ({words} {value})"
    if rule.outputs is not None:
        names = {s.identifier: s.name for s in node.outputs}
        yield from (f"{label} ({names[o]})" for o in sorted(outputs - rule.outputs))
    names = {s.identifier: s.name for s in node.inputs}
    yield from (f"{label} ({names[i]} by a link)" for i in rule.constant if inputs.get(i, 0) is None)
    if len(getattr(node, "sample_attribute_items", ())) and outputs - RAY_OUTPUTS:
        yield f"{label} (attributes of what it meets)"
    if not is_plain(getattr(node, "texture_mapping", None)) and node.bl_idname not in GENERATED | {"ShaderNodeTexImage"}:
        yield f"{label} (with a texture mapping of its own)"


def is_plain(mapping):
    """Whether the mapping that textures have from old files, and no panel shows, is the identity for Cycles, which knows no
    least and most."""
    if mapping is None:
        return True
    return (
        (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z) == ("X", "Y", "Z")
        and not any(mapping.translation)
        and not any(mapping.rotation)
        and all(v == 1 for v in mapping.scale)
    )
