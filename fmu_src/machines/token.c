/* Which partner is this? A hash over its table: it binds an XML file to its binary. */
#include "machine.h"

/* FNV-1a, 64 bits. */
static uint64_t mix(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ ((const unsigned char *)bytes)[i]) * 1099511628211u;
    return hash;
}

static uint64_t mix_text(uint64_t hash, const char *text)
{
    for (; text && *text; ++text)
        hash = mix(hash, text, 1);
    return mix(hash, "", 1);
}

static uint64_t hash_table(uint64_t hash)
{
    for (int i = 0; i < part.count; ++i) {
        const struct Variable *v = &part.variables[i];
        const double numbers[] = {v->start, v->min, v->max, v->nominal};
        const int32_t kinds[] = {(int32_t)v->type, (int32_t)v->causality, (int32_t)v->variability, v->derivative_of};
        hash = mix_text(mix_text(mix_text(hash, v->name), v->unit), v->display_unit);
        hash = mix_text(mix_text(hash, v->meaning), v->source);
        hash = mix(mix(hash, numbers, sizeof numbers), kinds, sizeof kinds);
        for (const char *const *choice = v->choices; choice && *choice; ++choice)
            hash = mix_text(hash, *choice);
    }
    return mix_text(hash, part.equations);
}

void kernel_token(char token[39])
{
    static const char form[] = "{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}";
    uint64_t hash = 14695981039346656037u;
    int digit = 0;
    for (int i = 0; i < 39; ++i) {
        if (form[i] == 'x' && digit % 16 == 0)
            hash = hash_table(hash);
        token[i] = form[i] == 'x' ? "0123456789abcdef"[hash >> 4 * (digit % 16) & 15] : form[i];
        digit += form[i] == 'x';
    }
}
