<ColorCorrection id="warm">
    <SOPNode><Slope>1.1 1 0.9</Slope><Offset>0 0.01 0</Offset><Power>1 1.1 1</Power></SOPNode>
    <SATNode><Saturation>0.9</Saturation></SATNode>
</ColorCorrection>
