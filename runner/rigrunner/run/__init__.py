"""The life of a run: prepared, recorded, analysed, reported, resumed, made safe."""
