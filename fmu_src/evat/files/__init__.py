"""How do files come in and go out? Read as something that a stranger sent, written whole or not at all."""
