"""The terminal face: parse, call one public function, print."""
