// The libraries of report.html, bundled into one script that sets one global. Only what report.js uses is
// named here, so that the rest falls away.

import {
  BufferAttribute,
  BufferGeometry,
  ColorManagement,
  DataTexture,
  DepthTexture,
  LinearSRGBColorSpace,
  Mesh,
  NearestFilter,
  OrthographicCamera,
  PerspectiveCamera,
  PlaneGeometry,
  Points,
  Scene,
  ShaderMaterial,
  Vector3,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { barX, dot, legend, line, plot, raster, rect, ruleY, scale, text } from "@observablehq/plot";

const THREE = {
  BufferAttribute,
  BufferGeometry,
  ColorManagement,
  DataTexture,
  DepthTexture,
  LinearSRGBColorSpace,
  LineMaterial,
  LineSegments2,
  LineSegmentsGeometry,
  Mesh,
  NearestFilter,
  OrthographicCamera,
  PerspectiveCamera,
  PlaneGeometry,
  Points,
  Scene,
  ShaderMaterial,
  Vector3,
  WebGLRenderer,
  WebGLRenderTarget,
};
const Plot = { barX, dot, legend, line, plot, raster, rect, ruleY, scale, text };

globalThis.gmpcrLibraries = { THREE, OrbitControls, Plot };
